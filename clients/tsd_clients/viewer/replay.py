"""A log as a run that can be played, halted and moved through."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.robot.robot import Robot
from tsd_clients.logs.log import Log
from tsd_clients.viewer.shown_run import RunLabel, ShownRun, words_of
from tsd_clients.viewer.ticks import Ticks, limit_rows_of_log, ticks_of_log

# of what the charts show [s]
WINDOW = 10.0


class Replay:
    """Plays a log; also what the page polls, and the run that it shows.

    Attributes:
        label: What it is.
        begin: Time of the first tick [s].
        end: Time of the last tick [s].
        speed: 1 as fast as it was.
        playing: Whether time passes.
    """

    def __init__(self, path: Path, log: Log, robot: Robot) -> None:
        """Stand at the beginning, playing.

        Raises:
            InvalidValue: If the log is of another robot, or without a tick.
        """
        self._ticks = ticks_of_log(log)
        if not len(self._ticks):
            raise InvalidValue("log file", f"'{path}' without a tick", "the log of a run")
        if self._ticks.q.shape[1] != robot.nq or self._ticks.tau.shape[1] != robot.n:
            raise InvalidValue(
                "the log's q and tau",
                f"of sizes {(self._ticks.q.shape[1], self._ticks.tau.shape[1])}",
                f"those of {robot.name}, {(robot.nq, robot.n)}; name its robot with --robot",
            )
        self.label = RunLabel(
            key=str(path),
            robot=robot.name,
            robot_file=str(robot.path),
            model=log.model,
            motion="a log" if log.outline is None else log.outline.motion,
            parameters=words_of({} if log.outline is None else log.outline.parameters),
            axes=log.axes,
            learned=len(log.learned or log.axes),
            joints=tuple(robot.joint_names),
            contacts=tuple(contact.name for contact in robot.description.contacts),
            all_axes=tuple(
                (task.name, axis) for task in robot.description.all_tasks for axis in task.axes
            ),
            limit_rows=limit_rows_of_log(robot.joint_names),
            torque_limits=robot.torque_limit,
        )
        self.begin, self.end = float(self._ticks.time[0]), float(self._ticks.time[-1])
        self.speed, self.playing = 1.0, True
        self._time, self._polled = self.begin, float("nan")

    @property
    def time(self) -> float:
        """Of the tick that is shown [s]."""
        return self._time

    def move_to(self, time: float) -> None:
        """Go to a moment [s]."""
        self._time = min(max(time, self.begin), self.end)

    def poll(self, now: float) -> None:
        """Let time pass; from the end it begins again."""
        passed = now - self._polled
        self._polled = now
        if self.playing and passed > 0:
            over = self._time >= self.end
            self.move_to(self.begin if over else self._time + self.speed * passed)

    def close(self) -> None:
        """Nothing is open."""

    @property
    def shown(self) -> tuple[ShownRun, ...]:
        """The one run."""
        return (self,)

    @property
    def state(self) -> str:
        """Where it stands."""
        return "playing" if self.playing else "paused"

    @property
    def ticks(self) -> Ticks:
        """The ticks before the moment, for as long as the charts show."""
        stop = int(np.searchsorted(self._ticks.time, self._time, side="right"))
        start = int(np.searchsorted(self._ticks.time, self._time - WINDOW))
        return self._ticks.part(min(start, max(stop, 1) - 1), max(stop, 1))
