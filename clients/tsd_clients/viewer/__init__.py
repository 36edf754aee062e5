"""The live page: robots, charts, services and replays in a browser."""
