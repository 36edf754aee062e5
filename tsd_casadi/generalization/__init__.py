"""Feedforward for parameters that were never tried [generalization], and how sure it is."""
