"""Public humanoids, each from its description and the names of its feet."""
