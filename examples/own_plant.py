"""Learn a squat on a simulation of your own: no MuJoCo, no service, two minutes.

A plant is whatever is measured and takes torques, a robot as well as this: rigid
bodies from Pinocchio whose soles are glued to the ground. It is 10 % lighter than
its controller believes. Usage: python own_plant.py [AMPLITUDE [FREQUENCY]]
"""

from __future__ import annotations

import sys
import tempfile

import numpy as np
import pinocchio

import tsd_casadi as tsd
from tsd_casadi import Plant, State, Truth

STIFFNESS = 400.0  # 1/s^2, of Baumgarte's spring and damper that keep the soles in place
DAMPING = 40.0  # 1/s


class GluedFeet(Plant):
    """M a + h = S^T tau + J^T f, the soles' acceleration J a + dJ v = -D J v - K e."""

    def __init__(self, robot: tsd.Robot, too_heavy: float) -> None:
        """Make a robot that is lighter than its controller believes."""
        self.robot = robot
        self.velocity_time = -self.period / 2  # semi-implicit: half a step older
        self._model = robot.model.copy()
        for index, inertia in enumerate(robot.model.inertias):
            self._model.inertias[index] = pinocchio.Inertia(
                inertia.mass / (1 + too_heavy), inertia.lever, inertia.inertia / (1 + too_heavy)
            )
        self._data = self._model.createData()

    def start(self, posture: State, seed: int = 0) -> None:
        """Stand at rest."""
        self._q, self._v = posture.q.copy(), posture.v.copy()
        self._soles = self.robot.sole_placements(posture.q)

    def measure(self) -> State:
        """Perfect sensors."""
        return State(self._q.copy(), self._v.copy())

    def truth(self) -> Truth:
        """Say where it is; a robot cannot, and leaves this away."""
        com = pinocchio.centerOfMass(self._model, self._data, self._q)
        return Truth(self.measure(), com.copy())

    def apply(self, tau: np.ndarray) -> None:
        """One step of semi-implicit Euler."""
        model, data, q, v = self._model, self._data, self._q, self._v
        J, drift = [], []  # of both soles: the drift is dJ v + D J v + K e
        pinocchio.forwardKinematics(model, data, q, v, np.zeros(model.nv))
        for frame, home in zip(self.robot.sole_frames, self._soles, strict=True):
            sole = pinocchio.updateFramePlacement(model, data, frame)
            local = pinocchio.LOCAL
            bias = pinocchio.getFrameAcceleration(model, data, frame, local).vector
            twist = pinocchio.getFrameVelocity(model, data, frame, local).vector
            off = pinocchio.log6(home.actInv(sole)).vector
            J.append(pinocchio.computeFrameJacobian(model, data, q, frame, local))
            drift.append(bias + DAMPING * twist + STIFFNESS * off)
        force = np.concatenate((np.zeros(6), tau))
        a = pinocchio.forwardDynamics(
            model, data, q, v, force, np.vstack(J), np.concatenate(drift), 1e-12
        )
        self._v = v + self.period * a
        self._q = pinocchio.integrate(model, q, self.period * self._v)


amplitude = float(sys.argv[1]) if sys.argv[1:] else 0.03
frequency = float(sys.argv[2]) if sys.argv[2:] else 0.5
robot = tsd.load_robot("hermes_lower")
controller = tsd.compile_controller(robot)
plant = GluedFeet(robot, too_heavy=0.1)
with tempfile.TemporaryDirectory() as folder, tsd.Database(f"{folder}/own.sqlite") as database:
    runs = tsd.learn(plant, controller, [tsd.Squat(amplitude, frequency)], database, iterations=2)

for run in runs:
    error = run.errors["com.z"]
    print(f"iteration {run.feedforward.iteration}: RMS error {1e6 * error.rms:10.3f} um")
