"""What a user would do instead of learning task accelerations, in the same runs."""
