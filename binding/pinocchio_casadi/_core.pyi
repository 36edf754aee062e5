"""The compiled part: see binding/symbolic_model.hpp."""

import numpy as np
from numpy.typing import NDArray

class SymbolicModel:
    """A Pinocchio model over casadi::SX."""

    def __init__(self, gravity: NDArray[np.float64]) -> None: ...
    def add_joint(
        self,
        parent: int,
        type: str,
        axis: NDArray[np.float64],
        rotation: NDArray[np.float64],
        translation: NDArray[np.float64],
        name: str,
        mass: float,
        lever: NDArray[np.float64],
        inertia: NDArray[np.float64],
        armature: NDArray[np.float64],
    ) -> int: ...
    @property
    def nq(self) -> int: ...
    @property
    def nv(self) -> int: ...
    def mass_matrix(self) -> str: ...
    def bias_forces(self) -> str: ...
    def center_of_mass(self) -> str: ...
    def frame(
        self,
        joint: int,
        rotation: NDArray[np.float64],
        translation: NDArray[np.float64],
        name: str,
        local: bool,
    ) -> str: ...
