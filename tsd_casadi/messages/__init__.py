"""The JSON messages of the network, checked where they come in."""
