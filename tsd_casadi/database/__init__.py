"""The store of what was learned: entries, their iterations and recordings."""
