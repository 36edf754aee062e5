"""Whole-body control that learns task-specific dynamics.

A robot's files become a symbolic task-space inverse dynamics QP, compiled to C
(``compile_controller``); what its feedback had to add is learned and added as
feedforward (``Database``), after Gams, Mason, Ude, Schaal and Righetti,
"Learning Task-Specific Dynamics to Improve Whole-Body Control".
"""

import lazy_loader

# what is exported stands in __init__.pyi; nothing is imported before it is used
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
