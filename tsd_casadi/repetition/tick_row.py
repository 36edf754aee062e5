"""A tick as one row of numbers, for whoever takes notes of it outside of the loop's process."""

from __future__ import annotations

import numpy as np

from tsd_casadi.repetition.compensator import Moment, Setting
from tsd_casadi.state import Vector
from tsd_casadi.tick.row_layout import row_layout


class TickRow:
    """Writes ticks as rows of one layout.

    Attributes:
        layout: What the numbers of a row are.
    """

    def __init__(self, setting: Setting) -> None:
        """Lay out the rows of a repetition."""
        known = setting.controller.format
        self.layout = row_layout(known, len(setting.axes), setting.robot.nq)
        self._nothing = np.full(known.reply.size, np.nan)
        self._nowhere = np.full(setting.robot.nq, np.nan)
        self._at_rest = np.full(setting.robot.nv, np.nan)

    def of(self, moment: Moment) -> Vector:
        """Write a tick that was answered or missed down.

        Returns:
            (layout.size,).
        """
        state, truth, missed = moment.state, moment.truth, moment.missed
        head = (
            moment.time,
            moment.phase,
            moment.lap,
            moment.share,
            0 if missed is None else int(missed.cause),
            moment.tick_time,
        )
        return np.concatenate(
            (
                head,
                moment.reference.x,
                moment.true_error,
                moment.feedforward,
                moment.tau,
                state.q,
                state.v,
                self._nowhere if truth is None else truth.state.q,
                self._at_rest if truth is None else truth.state.v,
                self._nothing if moment.tick is None else moment.tick.reply,
            )
        )
