"""Asked here: is it noticed when a feedforward learned for something else does harm?"""
