"""Feet that come and go: how far torques jump when a contact is ramped, and when it is switched.

Run: python -m benchmarks.contacts [--robots NAME|FILE ...] [--figure FILE] [--json FILE]

The centre of mass sways over the other foot, or of a quadruped over the other three;
then one foot's contact goes out over 0.2 s, stays out for half a second and comes in
again, before the centre of mass sways back. Simulated at 1 kHz. What counts is the
largest change of a joint's torque from one tick to the next, of its limit, from the
beginning of the one ramp to shortly after the other one.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tsd_casadi.compilation.compile_controller import compile_controller
from tsd_casadi.controller.controller import Controller
from tsd_casadi.motions.hold import hold
from tsd_casadi.robot.reaching import reach
from tsd_casadi.robot.robot import Robot, load_robot
from tsd_casadi.state import State, Vector
from tsd_clients.console.table import Column, print_table
from tsd_clients.simulator.simulator import MujocoSimulator

QUADRUPED = (
    Path(__file__).parents[1] / "tests" / "robots" / "mini_quadruped" / "mini_quadruped.yaml"
)
ROBOTS = ("hermes_lower", "g1", "talos", str(QUADRUPED))
LARGEST_CHANGE = 0.02  # of a joint's limit, per tick
FALLEN = 0.8  # of the height of the centre of mass at home
RAMP = 0.2  # [s]
# when what begins [s]
SWAY, OUT, IN, BACK, END = 0.3, 2.3, 3.0, 3.7, 5.7
SETTLED = 1.5  # of a sway [s]


@dataclass(frozen=True)
class Trace:
    """What happened, tick by tick.

    Attributes:
        time: (ticks,) [s].
        active: Of the contact, (ticks,).
        torque: Of each joint's limit, (ticks, n).
        force: Planned normal force of the foot, of the robot's weight, (ticks,).
        fell: Whether the robot fell, or a tick failed.
    """

    time: Vector
    active: Vector
    torque: Vector
    force: Vector
    fell: bool

    @property
    def largest_change(self) -> float:
        """From one tick to the next, of a joint's limit, while the contact comes and goes."""
        about = (self.time >= OUT - 0.01) & (self.time < IN + RAMP + 0.1)
        return float(np.abs(np.diff(self.torque[about], axis=0)).max())


def level(time: float, ramp: float) -> float:
    """Tell the contact's ``active`` at a time; a ramp of zero is a switch."""
    if ramp == 0.0:
        return 0.0 if OUT <= time < IN else 1.0
    return float(np.clip(1 - (time - OUT) / ramp, 0, 1) + np.clip((time - IN) / ramp, 0, 1))


def posture_over_the_others(robot: Robot, contact: str) -> State:
    """Find the posture with the centre of mass over the middle of the other feet.

    Raises:
        ValueError: If it is out of reach.
    """
    places = zip(robot.feet, robot.sole_placements(robot.home.q), strict=True)
    corners = [foot.corners(place)[:, :2] for foot, place in places if foot.name != contact]
    way = np.vstack(corners).mean(axis=0) - robot.home_com[:2]
    if len(corners) > 1:
        way *= 0.6  # well inside of the triangle
    else:
        way[0] = 0.0  # a sole is long
    com = robot.axis_for("", "com", "x").split(".")[0]
    posture = reach(robot, robot.home, {f"{com}.x": way[0], f"{com}.y": way[1]})
    if posture is None:
        raise ValueError(f"{robot.name} cannot bring its centre of mass over the others")
    return posture


def run(robot: Robot, controller: Controller, contact: str, ramp: float) -> Trace:
    """Sway, lift one foot's weight off, put it back, sway back.

    Args:
        contact: Name of the one that goes.
        ramp: [s]; 0 switches.
    """
    over = posture_over_the_others(robot, contact)
    simulator = MujocoSimulator(robot)
    body = simulator.body(robot.home, robot.home, 0)
    command = controller.command()
    time = np.arange(0, END, simulator.period)
    torque, force, active, fell = [], [], [], False
    for now in time:
        _, measured = body.measure()
        share = np.clip((now - SWAY) / SETTLED, 0, 1) - np.clip((now - BACK) / SETTLED, 0, 1)
        share = 0.5 - 0.5 * np.cos(np.pi * share)
        q = robot.home.q + share * (over.q - robot.home.q)
        q[3:7] /= np.linalg.norm(q[3:7])
        hold(command, robot, State(q, over.v))
        command[f"{contact}.active"] = level(now, ramp)
        tick = controller.tick(measured, command)
        fell |= bool(tick.status != 0 or body.com[2] < FALLEN * robot.home_com[2])
        torque.append(tick.tau / robot.torque_limit)
        force.append(tick.wrenches[contact][2] / robot.weight)
        active.append(command[f"{contact}.active"][0])
        body.step(tick.tau, now)
    return Trace(time, np.array(active), np.array(torque), np.array(force), fell)


def measure(name: str) -> tuple[str, dict[str, Trace]]:
    """Run one robot with ramps and with a switch."""
    robot = load_robot(name)
    controller = compile_controller(robot)
    contact = robot.description.contacts[0].name
    return robot.name, {
        kind: run(robot, controller, contact, ramp)
        for kind, ramp in (("ramp", RAMP), ("switch", 0.0))
    }


def draw(results: dict[str, dict[str, Trace]], path: Path) -> None:
    """Draw the force and the joint that jumps most, with ramps and with a switch."""
    from matplotlib import pyplot as plt

    figure, panels = plt.subplots(
        3, len(results), figsize=(3.2 * len(results), 6.4), sharex=True, squeeze=False
    )
    for column, (name, traces) in enumerate(results.items()):
        switched = traces["switch"]
        about = (switched.time > OUT - 0.1) & (switched.time < IN + RAMP + 0.2)
        joint = int(np.abs(np.diff(switched.torque[about], axis=0)).max(axis=0).argmax())
        for kind, trace in traces.items():
            time = trace.time[about]
            panels[0, column].plot(time, trace.active[about], label=kind)
            panels[1, column].plot(time, trace.force[about], label=kind)
            panels[2, column].plot(time, trace.torque[about, joint], label=kind)
        panels[0, column].set_title(name)
        panels[2, column].set_xlabel("time [s]")
    for row, label in enumerate(("active", "normal force / weight", "torque / limit")):
        panels[row, 0].set_ylabel(label)
    panels[0, 0].legend()
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    plt.close(figure)


def show(results: dict[str, dict[str, Trace]]) -> None:
    """Print a table."""

    def change(kind: str) -> list[str]:
        return [f"{100 * traces[kind].largest_change:.2f}" for traces in results.values()]

    def fell(kind: str) -> list[str]:
        return ["yes" if traces[kind].fell else "no" for traces in results.values()]

    print_table(
        "largest change of a torque per tick, of the joint's limit [%]",
        [
            Column("robot", list(results), is_text=True),
            Column(f"ramp of {RAMP:g} s\n<= {100 * LARGEST_CHANGE:g}", change("ramp")),
            Column("fell", fell("ramp"), is_text=True),
            Column("switch", change("switch")),
            Column("fell", fell("switch"), is_text=True),
        ],
    )


def main() -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--robots", nargs="+", default=ROBOTS, help="names or robot files")
    parser.add_argument("--figure", type=Path, help="draw it into this file")
    parser.add_argument("--json", type=Path, help="write the numbers to this file")
    arguments = parser.parse_args()
    results = dict(measure(name) for name in arguments.robots)
    show(results)
    if arguments.figure:
        draw(results, arguments.figure)
    if arguments.json:
        numbers: dict[str, Any] = {
            name: {
                kind: {"largest_change": trace.largest_change, "fell": trace.fell}
                for kind, trace in traces.items()
            }
            for name, traces in results.items()
        }
        arguments.json.write_text(json.dumps(numbers, indent=2))


if __name__ == "__main__":
    main()
