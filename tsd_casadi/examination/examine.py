"""Everything that is looked at before a robot is trusted with a motion."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from typing import Any

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.examination.finding import Finding
from tsd_casadi.examination.impossible_links import impossible_links
from tsd_casadi.examination.misplaced_soles import misplaced_soles
from tsd_casadi.examination.motion_demands import (
    Demand,
    MotionDemands,
    demands_of,
    torque_at_rest,
)
from tsd_casadi.examination.suspicious_numbers import suspicious_numbers
from tsd_casadi.examination.torque_speed import (
    TorqueSpeedLine,
    torque_speed_lines,
    unreachable_speeds,
)
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.motions.catalogue import shipped_motions
from tsd_casadi.motions.motion import Motion
from tsd_casadi.motions.ranges import range_of
from tsd_casadi.robot.description import read_description
from tsd_casadi.robot.robot import Robot

# nearer to its limits a joint meets them when something pushes [rad, m]
LEAST_MARGIN = 0.1
# beyond this share of a limit nothing is left for what the model gets wrong
LARGEST_SHARE = 0.9
# a centre of pressure nearer to the edge tips the robot when something pushes: 5 mm are
# 2 N m of an adult's weight [m]
LEAST_PRESSURE_MARGIN = 5e-3
# motions are looked at as often as the paper's: twice as fast needs four times the
# accelerations, which are still small beside the weight [Hz]
FREQUENCY = 0.25


@dataclass(frozen=True)
class Examination:
    """What was found.

    Attributes:
        findings: The worst first.
        demands: What each end of each motion's range asks for.
        lines: What motors have left at speed, where the robot file says so.
    """

    findings: tuple[Finding, ...]
    demands: tuple[MotionDemands, ...]
    lines: tuple[TorqueSpeedLine, ...] = ()

    @property
    def works(self) -> bool:
        """Whether nothing was found that cannot work."""
        return all(finding.severity != "error" for finding in self.findings)

    def plain(self) -> dict[str, Any]:
        """Give plain data, for JSON."""
        return {
            "works": self.works,
            "findings": [finding.plain() for finding in self.findings],
            "motions": [_plain(demands) for demands in self.demands],
            "torque_speed": [asdict(line) for line in self.lines],
        }


def examine(
    robot: Robot,
    controller: WholeBodyController,
    progress: Callable[[int, int], object] = lambda done, total: None,
) -> Examination:
    """Examine a robot that was loaded.

    Args:
        progress: Called with motions done and all of them.
    """
    description = read_description(
        robot.source_path, "urdf" if robot.description.mjcf is None else "mjcf"
    )
    overridden = {f"link {name}" for name in robot.description.links}
    lines = torque_speed_lines(robot)
    findings = [
        *suspicious_numbers(robot),
        *misplaced_soles(robot),
        *unreachable_speeds(lines),
    ]
    findings += [
        finding
        for finding in impossible_links(description, robot.path.name)
        if finding.element not in overridden
    ]
    motions = list(_ends(robot))
    rest = torque_at_rest(robot, controller)
    demands = []
    for index, motion in enumerate(motions):
        demands.append(demands_of(robot, controller, motion))
        findings += _judge(demands[-1], rest)
        progress(index + 1, len(motions))
    order = ("error", "warning", "note")
    findings.sort(key=lambda finding: order.index(finding.severity))
    return Examination(tuple(findings), tuple(demands), lines)


def _ends(robot: Robot) -> Iterator[Motion]:
    """List each shipped motion at the ends of its range, one parameter at a time."""
    for kind in shipped_motions().values():
        items = kind.declaration().parameters
        try:
            ranges = {item.name: range_of(robot, kind, item) for item in items}
        except InvalidValue:
            continue  # the robot has no task that carries it
        low, high = ranges["frequency"]
        usual = {item.name: ranges[item.name][0] for item in items if item.default is None}
        usual |= {item.name: item.default for item in items if item.default is not None}
        usual["frequency"] = min(max(FREQUENCY, low), high)
        for item in items:
            if item.extent or item.place:
                ends = {ranges[item.name][1]} if item.extent else set(ranges[item.name])
                for end in sorted(ends - {0.0}):
                    yield kind(**{**usual, item.name: end})


def _judge(demands: MotionDemands, rest: Demand) -> Iterator[Finding]:
    element = told(demands.motion)
    part = f"'motions: {{{demands.motion.name}: ...}}' in the robot file"
    if demands.failure is not None:
        yield Finding("error", element, demands.failure, f"a smaller range, {part}")
        return
    joint, torque, friction = demands.joint, demands.torque, demands.friction
    assert joint is not None and torque is not None and friction is not None
    if joint.value < LEAST_MARGIN:
        yield Finding(
            "warning" if joint.value > 0 else "error",
            element,
            f"brings {joint.of} to {joint.value:.3f} rad from its limit where the model is 10 % "
            f"wrong, less than {LEAST_MARGIN:g}",
            f"another home posture, or a smaller range, {part}",
        )
    if torque.value > LARGEST_SHARE:
        yield Finding(
            "warning",
            element,
            f"needs {100 * torque.value:.0f} % of the torque of {torque.of}",
            f"a smaller range, {part}"
            if rest.value <= LARGEST_SHARE
            else f"another home posture, home alone needs {100 * rest.value:.0f} % of "
            f"{rest.of}; or 'effort: {{{rest.of}: ...}}' in the robot file, if the motor has more",
        )
    if friction.value > LARGEST_SHARE:
        yield Finding(
            "warning",
            element,
            f"needs {100 * friction.value:.0f} % of the friction at {friction.of}",
            f"a smaller range, {part}, or more friction",
        )
    assert demands.pressure is not None
    if demands.pressure < LEAST_PRESSURE_MARGIN:
        yield Finding(
            "warning",
            element,
            f"moves the centre of pressure to {1e3 * demands.pressure:.1f} mm from the edge of "
            "what the feet span",
            f"a smaller range, {part}, or a home posture with the weight over the feet's middle",
        )


def told(motion: Motion) -> str:
    """Tell people a motion with its parameters."""
    values = [f"{name}={value:.3g}" for name, value in motion.parameters.items() if value]
    return " ".join([motion.name, *values])


def _plain(demands: MotionDemands) -> dict[str, Any]:
    parts = {name: getattr(demands, name) for name in ("joint", "torque", "friction")}
    return {
        "motion": demands.motion.name,
        "parameters": demands.motion.parameters,
        "failure": demands.failure,
        "pressure": demands.pressure,
        **{name: None if part is None else vars(part) for name, part in parts.items()},
    }
