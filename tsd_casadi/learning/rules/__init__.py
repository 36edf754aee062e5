"""Learning rules, one file each: what is served, and how the next weights come about."""
