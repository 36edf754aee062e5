"""Repetitions as others watch them: what they say of themselves, published while they run."""
