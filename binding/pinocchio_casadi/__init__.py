"""Pinocchio's CasADi interface for the wheels of PyPI.

The wheel ``pin`` has no ``pinocchio.casadi``. This package compiles what is
needed of it against the headers that the wheels ship: Pinocchio's own
algorithms run on ``casadi::SX`` and their results come back as ordinary
``casadi.Function`` objects, ready to be differentiated, expanded or written
as C code::

    import pinocchio
    from pinocchio_casadi import SymbolicModel

    symbolic = SymbolicModel(pinocchio.buildModelFromUrdf("robot.urdf"))
    M = symbolic.mass_matrix()(q)
    c, J, drift = symbolic.center_of_mass()(q, v)

Conventions are Pinocchio's: q holds the base position, the base quaternion
xyzw (unit) and the joints; v the base linear and angular velocity in the base
frame and the joint velocities.
"""

from pinocchio_casadi.symbolic_model import SymbolicModel, UnsupportedJoint

__all__ = ["SymbolicModel", "UnsupportedJoint"]
