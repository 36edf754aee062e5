r"""Learning in joint torques instead of task accelerations, the usual alternative.

.. math::

    \tau_{ff,i}(\phi) = \tau_{ff,i-1}(\phi) + \tau_{fb,i-1}(\phi), \qquad
    \tau_{fb} = \tau - \tau\big|_{P = D = 0}

The feedback of every task and of the posture, as the torques that the
controller made of it, is added to the torques of the next repetition: feedback
error learning as in Pollard and Atkeson, and the torques of Denisa et al.'s
compliant movement primitives. One periodic signal for each joint.
"""

from __future__ import annotations

import numpy as np

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.exceptions import InvalidValue, SimulationError
from tsd_casadi.motions.motion import Motion
from tsd_casadi.repetition.compensator import Compensator, Moment, Setting
from tsd_casadi.repetition.gains import UNCHANGED, Gains
from tsd_casadi.repetition.run import Run
from tsd_casadi.state import Vector
from tsd_clients.simulator.simulator import MujocoSimulator
from tsd_experiments.comparison.baselines.torque_feedforward import LearnedTorque, TorqueFeedforward


class FeedbackTorque(Compensator):
    """Records which part of the torques is feedback.

    At every tick it asks the controller a second time, at the same state and
    command, with P and D of all tasks and of the posture at zero.

    Attributes:
        torques: One (n,) per tick [N m].
    """

    def __init__(self) -> None:
        """Start empty."""
        self.torques: list[Vector] = []

    def start(self, setting: Setting) -> None:
        """Forget the last run."""
        self._controller = setting.controller
        self._without = setting.controller.command()
        names = [task.name for task in setting.robot.description.tasks]
        self._gains = [f"{name}.{gain}" for name in (*names, "posture") for gain in "PD"]
        self.torques = []

    def after(self, moment: Moment) -> None:
        """Ask again without feedback."""
        assert moment.tick is not None
        self._without.request[:] = moment.command.request
        for gain in self._gains:
            self._without[gain] = 0.0
        without = self._controller.tick(moment.state, self._without)
        self.torques.append(moment.tick.tau - without.tau)


def learn_joint_torques(
    simulator: MujocoSimulator,
    controller: WholeBodyController,
    motion: Motion,
    iterations: int,
    *,
    laps: int = 3,
    gains: Gains = UNCHANGED,
    seed: int = 0,
) -> tuple[list[Run], TorqueFeedforward]:
    """Repeat a motion, learning torques from one repetition to the next.

    N iterations are N repetitions; how well the result does, another run tells.

    Args:
        laps: Least number of laps of each run.
        gains: Factors on the learned task's gains.

    Returns:
        The repetitions learned from, and what was learned.

    Raises:
        InvalidValue: If iterations is not at least 1.
        SimulationError: If the robot fell, a tick failed, or the feedback never
            settled.
    """
    if iterations < 1:
        raise InvalidValue("iterations", iterations, "at least 1")
    learned = TorqueFeedforward.zero(simulator.robot.joint_names, motion.parameters)
    runs = []
    for _ in range(iterations):
        recorded = FeedbackTorque()
        run = simulator.run(
            controller,
            motion,
            axes=motion.axes(simulator.robot),
            laps=laps,
            gains=gains,
            compensators=[recorded, LearnedTorque(learned)],
            seed=seed,
        )
        learned = add_feedback(learned, run, recorded)
        runs.append(run)
    return runs, learned


def add_feedback(
    applied: TorqueFeedforward, run: Run, recorded: FeedbackTorque
) -> TorqueFeedforward:
    """Add a repetition's feedback to the torques for the next one.

    Returns:
        Applied plus fitted.

    Raises:
        SimulationError: If the robot fell, a tick failed, or the feedback never
            settled.
    """
    if run.fell or run.failures or not run.steady:
        what = "fell" if run.fell else "failed ticks" if run.failures else "did not settle"
        raise SimulationError(
            f"nothing can be learned from a repetition that {what}; try a larger P or a "
            "slower or smaller motion"
        )
    measured = run.log["measured"]
    feedback = np.array(recorded.torques)[measured].T
    weights = applied.weights + applied.basis.fit(run.log["phase"][measured], feedback)
    return TorqueFeedforward(applied.joints, applied.basis, weights, applied.parameters)
