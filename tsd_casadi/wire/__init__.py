"""Both sides of the network: keys, endpoints and messages."""
