"""Asked here: does the true centre of mass follow, rather than the one the model computes?"""
