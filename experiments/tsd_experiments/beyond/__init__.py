"""Questions that the paper leaves open: one file or package each, named for the question."""
