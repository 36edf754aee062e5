"""A robot as data: its model, its file, how it stands, and what is refused."""
