r"""Drops a borrowed feedforward while it does more harm than good.

The error e of the learned axes and what a feedforward u contributes to it obey,
as far as the task is controlled by inverse dynamics,

.. math::

    \ddot e + D \dot e + P e = d - u, \qquad
    \ddot e_u + D \dot e_u + P e_u = u ,

with d what the model lacks. Of u that was applied, their sum is the error
:math:`e_0` that would be there without any. Of the whole term U, applied or not,
the same gives what it would move. Both sides of the question whether the term
helps are therefore known whether it is in use or not (``evidence``), axes counted as
the feedback counts them: a term that is dropped comes back when it would help.

That is a model of the loop, linear in the error. It holds where the robot is near
its reference; at gains so low that it is centimetres off, what it lacks there is
not what it lacks at the reference, and its joints may end before the predicted
place. The remarks say both errors, and which of them was predicted. Where such a
guess does not speak clearly for a term, the robot is tried without it, once: then
the error without it is measured, and the term comes back as any other would.

The standing before the motion is judged, too, by what is in use of the term while it
is being phased in: one of the wrong sign is dropped before much of it is in use. In the motion a
lap decides, or half of one that is clear. A term comes back over a lap: what it
would do is known before all of it is in use. After a second drop only a whole lap
brings it back, after a pause of a lap, and each further pause is twice as long; that
is forgiven after ``PROVEN`` laps with it.
"""

from __future__ import annotations

from tsd_casadi.learning.axis_error import unit_of_axis
from tsd_casadi.repetition.compensator import Compensator, Moment, Setting
from tsd_casadi.repetition.evidence import CLEAR, Evidence, Seen
from tsd_casadi.repetition.guess import caution, is_doubtful
from tsd_casadi.repetition.loop_answer import LoopAnswer
from tsd_casadi.repetition.phasing import FADE, PhasedShare, settling_time

# of standing still: at P = 50, D = 14 the loop has made up 87 % of a step by then
STANDING = 0.5  # s
# in beta: a term whose RMS errors with and without differ by less than a tenth is not brought back
HYSTERESIS = 0.025
# laps in use after which earlier drops no longer count, more than one push and its end take
PROVEN = 5


class FeedforwardGate(Compensator):
    """Watches one repetition's feedforward.

    Attributes:
        name: Of the feedforward, for people: where it is from.
        dropped_at: When it was dropped last [s]; None while it is in use.
        drops: How often it was dropped, a trial without it included.
    """

    def __init__(self, name: str = "the borrowed feedforward") -> None:
        """Start with the feedforward in use."""
        self.name = name
        self._begin()

    def _begin(self) -> None:
        self.dropped_at: float | None = None
        self.drops = 0
        # once in a repetition, and while that goes on
        self._was_tried = self._is_tried = False
        self._remarks: list[str] = []
        self._share = PhasedShare(1.0)

    @property
    def veto(self) -> str | None:  # type: ignore[override]
        """Why the feedforward is not in use."""
        return None if self.dropped_at is None else self._remarks[-1]

    @property
    def errors(self) -> tuple[float, float]:
        """RMS errors with the feedforward and without it in the newest lap [m, rad].

        What is not in use is predicted; zero before there was a tick.
        """
        return self._lap_evidence.errors

    @property
    def remarks(self) -> tuple[str, ...]:  # type: ignore[override]
        """What became of the feedforward, but for the veto."""
        if self.dropped_at is not None:
            return tuple(self._remarks[:-1])
        if not self._lap_evidence.is_complete:
            return tuple(self._remarks)
        with_it, without_it = self.errors
        kept = (
            f"{self.name} was kept: an RMS error of {self._told(with_it)} with it, "
            f"{self._told(without_it)} predicted without"
        )
        return (*self._remarks, kept + caution(without_it))

    def start(self, setting: Setting) -> None:
        """Note which axes are learned; a repetition starts with the feedforward in use."""
        self._begin()
        units = {f"m{unit_of_axis(axis)}": None for axis in setting.axes[: setting.learned]}
        self._unit = ", ".join(units)
        self._setting, self._index = setting, setting.index[: setting.learned]
        self._lap_time = 1 / setting.motion.frequency
        lap = round(self._lap_time / setting.period)
        self._standing = Evidence(round(STANDING / setting.period))
        self._half_evidence, self._lap_evidence = Evidence(lap // 2), Evidence(lap)
        self._moving = False
        self._since = self._wait = self._back_from = 0.0
        # the answer to u as it left here, since others may add to it, and to all of the term
        self._applied, self._whole = LoopAnswer(setting), LoopAnswer(setting)

    def before(self, moment: Moment) -> None:
        """Let through as much of the feedforward as is in use."""
        share = self._share.at(moment.time)
        moment.feedforward *= share
        moment.share *= share
        learned = self._setting.learned
        self._u = moment.feedforward[:learned].copy()
        self._U = moment.offered[:learned].copy()

    def after(self, moment: Moment) -> None:
        """Weigh what was seen, and drop the feedforward or bring it back."""
        if moment.tick is None:
            return
        P, D = (self._setting.gain(moment.command, gain)[: len(self._u)] for gain in "PD")
        scale = float(P @ P) / len(P)  # axes that are not moved change nothing
        if scale > 0:
            without = P * (moment.tick.error[self._index] + self._applied.x)
            # standing still, friction holds the robot against what it is not yet asked for
            term = self._applied if moment.lap < 0 else self._whole
            moved = P * term.x
            products = (moved @ moved, moved @ without, without @ without)
            self._weigh(moment, Seen.of(*(float(each) / scale for each in products)))
        self._applied.follow(self._u, P, D)
        self._whole.follow(self._U, P, D)

    def _weigh(self, moment: Moment, seen: Seen) -> None:
        if moment.lap < 0:
            self._standing.add(seen)
            standing = self._standing
            if self.dropped_at is None and standing.is_complete and standing.harms(CLEAR):
                self._drop(standing, moment.time)
            return
        if not self._moving:
            self._moving, self._since = True, moment.time
        self._half_evidence.add(seen)
        self._lap_evidence.add(seen)
        half, lap = self._half_evidence, self._lap_evidence
        if self.dropped_at is None:
            if moment.time - self._since > PROVEN * self._lap_time:
                self._wait = 0.0
            if half.is_complete and half.harms(CLEAR):
                self._drop(half, moment.time)
            elif lap.is_complete and lap.harms():
                self._drop(lap, moment.time)
            elif lap.is_complete and not self._was_tried and is_doubtful(*lap.errors):
                self._try_without(moment)
        elif moment.time >= self._back_from:
            # a push is over by the next half lap; what harms in one half of each lap is not
            is_first = self._wait == 0.0
            helps = is_first and half.is_complete and half.helps(CLEAR)
            # what was only tried without has not proved to harm
            margin = 0.0 if self._is_tried else HYSTERESIS
            if helps or (lap.is_complete and lap.helps(margin)):
                self._bring_back(moment.time)

    def _try_without(self, moment: Moment) -> None:
        self._was_tried = self._is_tried = True
        self._drop(self._lap_evidence, moment.time, "tried without")
        # what is seen while the term fades is no more than the prediction again
        gains = (self._setting.gain(moment.command, gain)[: len(self._u)] for gain in "PD")
        self._back_from += settling_time(*gains) + self._lap_time

    def _drop(self, evidence: Evidence, time: float, how: str = "dropped") -> None:
        with_it, without_it = evidence.errors
        how_much = "what was in use of it" if evidence is self._standing else "all of it"
        self._remarks.append(
            f"{self.name} was {how} at {time:.2f} s: an RMS error of {self._told(with_it)} with "
            f"{how_much}, {self._told(without_it)} without, is predicted{caution(without_it)}"
        )
        self.dropped_at, self._since, self._back_from = time, time, time + self._wait
        self.drops += 1
        self._share.go_to(0.0, time, FADE)
        self._forget()

    def _bring_back(self, time: float) -> None:
        self._remarks.append(f"{self.name} came back at {time:.2f} s: it would help again")
        self.dropped_at, self._since = None, time
        self._wait = max(2 * self._wait, self._lap_time)
        self._is_tried = False
        self._share.go_to(1.0, time, self._lap_time)
        self._forget()

    def _told(self, error: float) -> str:
        return f"{1e3 * error:.3g} {self._unit}"

    def _forget(self) -> None:
        """Decide anew from what is seen from now on."""
        self._half_evidence.forget()
        self._lap_evidence.forget()
