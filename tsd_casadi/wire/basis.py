"""The basis of weights, on the network."""

from __future__ import annotations

from functools import lru_cache
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from tsd_casadi.document import Document, Finite
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.exceptions import MalformedMessage


class BasisMessage(Document):
    """A periodic basis, eqs. (basis_functions) and (psi) of the paper.

    Attributes:
        kind: 'periodic'; other kinds have other numbers.
        L: Number of functions.
        centres: c_j [rad].
        width: h.
    """

    kind: Literal["periodic"] = "periodic"
    L: Annotated[int, Field(ge=1, le=1000)]
    centres: Annotated[tuple[Finite, ...], Field(max_length=1000)]
    width: Annotated[float, Field(gt=0, lt=1e6)]

    @classmethod
    def of(cls, basis: PeriodicBasis) -> BasisMessage:
        """Describe a basis."""
        return _described(basis)

    def basis(self) -> PeriodicBasis:
        """Make the basis.

        Raises:
            MalformedMessage: If the centres are not 2 pi j / L.
        """
        basis = PeriodicBasis(self.L, self.width)
        if len(self.centres) != self.L or not np.allclose(
            self.centres, basis.centers, rtol=0, atol=1e-9
        ):
            raise MalformedMessage("basis.centres", "2 pi j / L for j = 0 ... L - 1")
        return basis


@lru_cache(100)
def _described(basis: PeriodicBasis) -> BasisMessage:
    # nearly all answers have the same
    return BasisMessage(L=basis.L, centres=tuple(basis.centers), width=basis.width)
