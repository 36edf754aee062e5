"""The centre of mass corrected from static poses, beyond the paper."""
