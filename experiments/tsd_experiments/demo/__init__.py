"""The whole idea in a few minutes: learning, lower gains, generalisation.

Both services run as processes of their own with a fresh database; every run
asks the controller over Zenoh at every tick.
"""
