"""Side-by-side measurements: python -m benchmarks.tick and the like."""
