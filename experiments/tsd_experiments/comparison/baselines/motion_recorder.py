"""From a repetition to observations of the robot's dynamics.

Only what the robot's own computer knows is used: measured states and commanded
torques. Steady laps are averaged over the phase, taken as periodic and
differentiated as Fourier series.
"""

from __future__ import annotations

import math

import numpy as np

from tsd_casadi.exceptions import SimulationError
from tsd_casadi.identification.observations import Observations
from tsd_casadi.repetition.compensator import Compensator, Moment, Setting
from tsd_casadi.repetition.run import Run
from tsd_casadi.state import Matrix, Vector

BINS = 200  # of a lap
HARMONICS = 10  # of the motion, what lies above is noise


class MotionRecorder(Compensator):
    """Keeps measured states and commanded torques; must be the last compensator.

    Attributes:
        q: One (nq,) per tick.
        v: One (nv,) per tick.
        tau: One (n,) per tick [N m].
    """

    def __init__(self) -> None:
        """Start empty."""
        self.q: list[Vector] = []
        self.v: list[Vector] = []
        self.tau: list[Vector] = []

    def start(self, setting: Setting) -> None:
        """Forget the last run."""
        self.q, self.v, self.tau = [], [], []

    def after(self, moment: Moment) -> None:
        """Keep this tick."""
        self.q.append(moment.state.q)
        self.v.append(moment.state.v)
        self.tau.append(np.array(moment.tau))


def observe(run: Run, recorder: MotionRecorder) -> Observations:
    """Average the steady laps of a repetition to observations of one lap.

    Returns:
        Its steady laps, averaged over the phase and smoothed.

    Raises:
        SimulationError: If there are none.
    """
    if run.fell or not run.steady:
        raise SimulationError(
            "nothing can be identified from a repetition that fell or did not settle; try a "
            "larger P or a slower or smaller motion"
        )
    measured = run.log["measured"]
    phase = run.log["phase"][measured]
    q, v, tau = (
        _average(phase, np.array(values)[measured])
        for values in (recorder.q, recorder.v, recorder.tau)
    )
    q = _harmonics(q, 0, 1.0)
    q[:, 3:7] /= np.linalg.norm(q[:, 3:7], axis=1, keepdims=True)
    omega = 2 * math.pi * run.motion.frequency
    return Observations(q, _harmonics(v, 0, omega), _harmonics(v, 1, omega), tau)


def _average(phase: Vector, values: Matrix) -> Matrix:
    """Average values over equal parts of a lap, (BINS, columns)."""
    index = np.floor(np.mod(phase / (2 * math.pi), 1.0) * BINS).astype(int) % BINS
    sums = np.zeros((BINS, values.shape[1]))
    np.add.at(sums, index, values)
    return np.asarray(sums / np.bincount(index, minlength=BINS)[:, None])


def _harmonics(values: Matrix, derivative: int, omega: float) -> Matrix:
    """Differentiate the lowest harmonics of one lap by time, (BINS, columns)."""
    spectrum = np.fft.rfft(values, axis=0)
    spectrum[HARMONICS + 1 :] = 0.0
    rate = 1j * omega * np.arange(len(spectrum))
    return np.fft.irfft(rate[:, None] ** derivative * spectrum, n=len(values), axis=0)
