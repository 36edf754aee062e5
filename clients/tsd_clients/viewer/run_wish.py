"""What a page asks to be run, as arguments of 'tsd': checked numbers and known names only.

What arrives from a page may come from anybody who reaches it, and what stands in a
database from anybody who recorded: a motion's name could be that of a file with code.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.motions.catalogue import shipped_motions
from tsd_casadi.wire.endpoints import check_endpoint
from tsd_clients.viewer.known_motion import KnownMotion

FEEDFORWARDS = ("generalised", "learned", "none")
MOST_ITERATIONS = 20
# of a simulated robot; beyond it falls or stands by chance
LARGEST_MODEL_ERROR = 0.5
_AXIS = re.compile(r"[A-Za-z][A-Za-z0-9_]*\.[a-z]{1,3}", re.ASCII)


@dataclass(frozen=True)
class RunWish:
    """A run that a page asks for.

    Attributes:
        command: What is to be done.
        known: The motion.
        parameters: Of the motion, SI units.
        model_error: Share by which the controller's masses are wrong.
        feedforward: What a simulation feeds forward.
        iterations: Of learning.
        in_real_time: Whether it goes by the clock, so that it can be watched.
    """

    command: Literal["simulate", "learn"]
    known: KnownMotion
    parameters: Mapping[str, float]
    model_error: float = 0.0
    feedforward: str = FEEDFORWARDS[0]
    iterations: int = 2
    in_real_time: bool = True

    def arguments(self, robots: Mapping[str, str], endpoints: Sequence[str]) -> list[str]:
        """Give the command's arguments, one word each; no shell reads them.

        Args:
            robots: What '--robot' takes for the robots that are known here, by name.
            endpoints: Of controller and learner; of the learner alone where there is no
                controller for the robot, which is then part of the run.

        Raises:
            InvalidValue: If something is not what a page can ask for.
        """
        self._check(robots)
        words = [self.command, self.known.motion, "--robot", robots[self.known.robot]]
        words += ["--axes", ",".join(self.known.axes), "--model-error", repr(self.model_error)]
        for name, value in self.parameters.items():
            words += [f"--{name.replace('_', '-')}", repr(float(value))]
        if self.command == "learn":
            words += ["--iterations", str(self.iterations)]
        else:
            words += ["--feedforward", self.feedforward]
        if self.in_real_time:
            words += ["--pace", "1"]
        for endpoint in endpoints:
            words += ["--connect", check_endpoint(endpoint)]
        return words if len(endpoints) > 1 else [*words, "--controller", "local"]

    def _check(self, robots: Mapping[str, str]) -> None:
        known = self.known
        if self.command not in ("simulate", "learn"):
            raise InvalidValue("command", repr(self.command), "simulate or learn")
        if known.robot not in robots:
            raise InvalidValue(
                "robot",
                f"'{known.robot}'",
                f"one whose file is known here: {', '.join(sorted(robots))}; run a robot of your "
                "own from the command line",
            )
        motion = shipped_motions().get(known.motion)
        if motion is None:
            raise InvalidValue(
                "motion",
                f"'{known.motion}'",
                f"one of {', '.join(shipped_motions())}; run a motion of your own from the "
                "command line",
            )
        declared = {each.name for each in motion.declaration().parameters}
        if set(self.parameters) != declared:
            raise InvalidValue(
                f"parameters of {known.motion}", ", ".join(self.parameters), ", ".join(declared)
            )
        for name, value in self.parameters.items():
            if not math.isfinite(value):
                raise InvalidValue(name, f"{value}", "a finite number")
        for axis in known.axes:
            if _AXIS.fullmatch(axis) is None:
                raise InvalidValue("axis", f"'{axis}'", "'task.axis'")
        if not 0 <= self.model_error <= LARGEST_MODEL_ERROR:
            raise InvalidValue("model error", self.model_error, f"0 to {LARGEST_MODEL_ERROR:g}")
        if self.feedforward not in FEEDFORWARDS:
            raise InvalidValue("feedforward", repr(self.feedforward), ", ".join(FEEDFORWARDS))
        if not 1 <= self.iterations <= MOST_ITERATIONS:
            raise InvalidValue("iterations", self.iterations, f"1 to {MOST_ITERATIONS}")
