"""A robot file proposed from a description and the names of two feet."""
