"""The QP of section III, put together from dynamics, constraints, tasks and costs.

CasADi lives here: the definition that what is compiled has to agree with.
"""
