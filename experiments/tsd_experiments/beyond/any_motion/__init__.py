"""The same learning on other motions and several axes at once."""
