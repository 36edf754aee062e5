"""Rigid-body dynamics as CasADi expressions: the whole [dynamics] and its two parts.

One file each for the joints' rows [actuated_dyn] and the base's [un-actuated_dyn].
"""
