"""The terminal: tables that fit it, progress on stderr."""
