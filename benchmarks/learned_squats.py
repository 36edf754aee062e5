"""A database file of a few squats, learned in a loop that is written down here.

No robot moves: what the feedback has to add is a formula, so that a file is made in a
second, and pages and pictures of it are the same every time.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from tsd_casadi.database.database import Database
from tsd_casadi.encoding.harmonics import analyze, sample_phases, synthesize
from tsd_casadi.encoding.laps import Lap
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.learning.axis_error import AxisError
from tsd_casadi.learning.circumstances import Circumstances
from tsd_casadi.learning.context import Context
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.instruction import Instruction
from tsd_casadi.learning.recording import Recording
from tsd_casadi.learning.rules.by_name import find_rule
from tsd_casadi.motions.squat import Squat
from tsd_casadi.state import Matrix

ROBOT = "hermes_lower"
AXES = ("com.x", "com.z")
CONTEXT = Context("00ff", "abcd")
FREQUENCY = 0.5  # Hz
AMPLITUDES = (0.02, 0.03, 0.045, 0.06, 0.08)  # m
P, D = 50.0, 14.0  # 1/s^2, 1/s
# of what is missing, that the feedback adds: a loop that is nearly as modelled
GAIN = 0.93
HARMONICS = 12
LAPS = 3
# from lap to lap, of the feedback [m/s^2]
SCATTER = 4e-3


def needed(amplitude: float) -> Matrix:
    """Compute what a robot needs whose controller believes it 10 % too heavy.

    Args:
        amplitude: Of the squat [m].

    Returns:
        (2, 256) [m/s^2].
    """
    phase = sample_phases()
    swing = amplitude * (2 * np.pi * FREQUENCY) ** 2
    # gravity and inertia, friction, knees that grow harder to bend the lower the robot is
    friction = 0.05 * np.tanh(np.cos(phase) * amplitude / 0.03)
    z = -0.75 + friction + 0.1 * swing * np.sin(phase) - 20 * amplitude**2 * np.cos(2 * phase)
    x = 0.06 - 0.2 * swing * np.sin(phase + 0.4) + 12 * amplitude**2 * np.sin(3 * phase)
    return np.stack([x, z])


def recording(amplitude: float, applied: Matrix, seed: int, sign: float = 1.0) -> Recording:
    """Make the recording of a squat.

    Args:
        amplitude: Of the squat [m].
        applied: Weights of the feedforward in use, (2, L) [m/s^2].
        seed: Of what differs from lap to lap.
        sign: Of what is needed.
    """
    basis, phase = PeriodicBasis(), sample_phases()
    draw = np.random.default_rng(seed)
    missing = sign * needed(amplitude) - basis.evaluate(phase, applied)
    orders = np.arange(HARMONICS + 1)
    response = P + 1j * orders * 2 * np.pi * FREQUENCY * D
    reference = np.stack([np.zeros_like(phase), amplitude * np.sin(phase)])
    laps = []
    for _ in range(LAPS):
        shaken = SCATTER * draw.normal(size=(2, HARMONICS + 1)) / (1 + orders)
        feedback = analyze(GAIN * missing, HARMONICS) + shaken
        error = synthesize(feedback / response)
        laps.append(Lap(phase, synthesize(feedback), error, reference))
    return Recording(
        key=EntryKey.of(
            ROBOT,
            Squat.name,
            Squat.version,
            AXES,
            {"amplitude": amplitude, "frequency": FREQUENCY, "height": 0.0},
            CONTEXT,
        ),
        basis=basis,
        applied=applied,
        laps=laps,
        errors={axis: _measured(laps, index) for index, axis in enumerate(AXES)},
        circumstances=Circumstances({"P": [P, P], "D": [D, D]}, {"seed": seed}, "written down"),
        declaration=Squat.declaration(),
    )


def learn_squats(
    path: Path,
    amplitudes: Sequence[float] = AMPLITUDES,
    iterations: int = 3,
    *,
    wrong: float | None = None,
) -> None:
    """Make a file with an entry for each amplitude.

    Args:
        wrong: An amplitude at which the robot was another one; none by default.
    """
    rule = find_rule("guarded")
    with Database(path) as database:
        for amplitude in amplitudes:
            weights = np.zeros((len(AXES), PeriodicBasis().L))
            for number in range(iterations + 1):
                recorded = recording(
                    amplitude, weights, number, -1.0 if amplitude == wrong else 1.0
                )
                instruction = Instruction(rule, update=number < iterations)
                entry, _ = database.record(recorded, instruction)
                weights = entry.iterations[-1].weights


def _measured(laps: Sequence[Lap], index: int) -> AxisError:
    errors = np.concatenate([lap.error[index] for lap in laps if lap.error is not None])
    feedback = np.concatenate([lap.feedback[index] for lap in laps])
    return AxisError(
        rms=float(np.sqrt(np.mean(errors**2))),
        peak=float(np.abs(errors).max()),
        ac_rms=float(errors.std()),
        mean_abs_feedback=float(np.abs(feedback).mean()),
    )


if __name__ == "__main__":
    learn_squats(Path(sys.argv[1]))
