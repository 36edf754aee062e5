"""The experiments of the paper and those that question it."""
