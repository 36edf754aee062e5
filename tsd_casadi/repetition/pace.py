"""A repetition against the clock."""

from __future__ import annotations

from dataclasses import dataclass

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.exceptions import ControllerSilent, InvalidValue
from tsd_casadi.fallback.fallback import Fallback, fallback_of
from tsd_casadi.repetition.clock import Clock, WallClock
from tsd_casadi.repetition.deadline import PunctualController, Uninterrupted
from tsd_casadi.repetition.patience import PATIENCE, check_patience
from tsd_casadi.repetition.torque_blend import TorqueBlend
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import State, Vector
from tsd_casadi.tick.command import Command
from tsd_casadi.tick.missed import Cause, Missed
from tsd_casadi.tick.tick import Tick

SLOWEST, FASTEST = 0.01, 10.0
# of the newest answer in how long answers take: that of a slow moment is forgotten
# within twenty periods, and one quick answer does not pass for all
NEWEST = 0.05
BEHIND = "this computer is behind; try a slower --pace"


@dataclass(frozen=True)
class Pace:
    """How fast a repetition goes by the clock, and for how long without an answer.

    Attributes:
        factor: Seconds of the repetition in one second; 1 is real time.
        patience: How long answers may be missing [s]; infinite for ever.
        fallback: What is applied meanwhile; the robot file's by default.
        clock: Which clock.
    """

    factor: float = 1.0
    patience: float = PATIENCE
    fallback: Fallback | None = None
    clock: Clock = WallClock()  # noqa: RUF009 - it has no state

    def __post_init__(self) -> None:
        """Refuse what is no pace.

        Raises:
            InvalidValue: If factor or patience is out of range.
        """
        if not SLOWEST <= self.factor <= FASTEST:
            raise InvalidValue("pace", self.factor, f"{SLOWEST:g} to {FASTEST:g}; 1 is real time")
        check_patience(self.patience)


class Periods:
    """The periods of one repetition, each with a deadline.

    Period k begins at t_0 + k T and its torque is due at t_0 + (k + 1) T, T being
    the control period over the pace. Who is behind does not move t_0: the periods
    that are over already are stepped with the fallback, as a robot would have been.
    """

    def __init__(
        self, controller: WholeBodyController, robot: Robot, period: float, pace: Pace
    ) -> None:
        """Prepare; time runs from the first period on.

        Args:
            period: Control period [s].
        """
        self._clock, self._duration, self._pace = pace.clock, period / pace.factor, pace
        self._controller: PunctualController = (
            controller if isinstance(controller, PunctualController) else Uninterrupted(controller)
        )
        self._fallback = fallback_of(robot, period) if pace.fallback is None else pace.fallback
        self._blend = TorqueBlend(robot.torque_limit)
        self._begun = 0.0
        self._count = -1
        self._answered = 0.0
        self._usual = 0.0  # how long an answer takes [s]
        self._skipped = False
        self._holding = False

    def begin(self) -> None:
        """Wait for the next period."""
        if self._count < 0:
            self._begun = self._answered = self._clock.now()
        self._count += 1
        self._clock.sleep_until(self._begun + self._count * self._duration)

    def tick(self, state: State, command: Command) -> Tick | Missed:
        """Ask for this period's torque; what is not there by its deadline is missed.

        Raises:
            ControllerSilent: If the patience is over.
        """
        now = self._clock.now()
        due = self._begun + (self._count + 1) * self._duration
        late = now >= due
        self._skipped = late or (due - now < self._usual and not self._skipped)
        if self._skipped:
            answer: Tick | Missed = Missed(Cause.LATE, BEHIND)
        else:
            answer = self._controller.tick_within(state, command, due - now)
            # also where it was there in time and this process was not
            end = self._clock.now()
            if end > due and isinstance(answer, Tick):
                answer = Missed(Cause.LATE, f"by {1e3 * (end - due):.3g} ms")
            if isinstance(answer, Tick):
                self._usual += NEWEST * (end - now - self._usual)
            elif answer.cause is Cause.LATE:  # it may have taken as long as a period
                self._usual += NEWEST * (self._duration - self._usual)
        if isinstance(answer, Tick):
            self._answered = now
        elif now - self._answered > self._pace.patience:
            raise ControllerSilent(self._pace.patience, str(answer))
        return answer

    def hold(self, state: State) -> Vector:
        """Compute the torque of a period without an answer, (n,) [N m]."""
        if not self._holding:
            self._fallback.latch(state)
            self._holding = True
        return self._blend.follow(self._fallback.torque(state), answered=False)

    def resume(self, tau: Vector) -> Vector:
        """Go on with an answered torque, gradually after a gap, (n,) [N m]."""
        self._holding = False
        applied = self._blend.follow(tau, answered=True)
        self._fallback.watch(applied)
        return applied
