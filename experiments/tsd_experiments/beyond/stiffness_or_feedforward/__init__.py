"""Asked here: low gain with feedforward, or high gain without, for the same error?"""
