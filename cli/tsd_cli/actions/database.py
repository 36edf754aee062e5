"""Files of what was learned: written, taken in and checked, without any service."""
