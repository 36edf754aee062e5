"""What is said of a repetition before its first tick."""

from __future__ import annotations

from pathlib import Path

from tsd_casadi.repetition.compensator import Setting
from tsd_casadi.wire.run_outline import RunOutline


def outline_of(setting: Setting) -> RunOutline:
    """Describe a repetition that is about to begin."""
    robot, motion = setting.robot, setting.motion
    return RunOutline(
        robot=robot.name,
        robot_file=str(Path(robot.path).absolute()),
        model=robot.fingerprint,
        motion=motion.name,
        version=motion.version,
        parameters=dict(motion.parameters),
        axes=setting.axes,
        learned=setting.learned,
        period=setting.period,
        nq=robot.nq,
        torque_limits=tuple(map(float, robot.torque_limit)),
        controller=setting.controller.format.plain(),
    )
