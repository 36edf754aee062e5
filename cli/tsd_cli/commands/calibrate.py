"""'tsd calibrate': correct the centre of mass."""

from __future__ import annotations

from tsd_cli.option_groups import with_groups
from tsd_cli.options.calibration import CalibrationOptions
from tsd_cli.options.output import JsonOptions
from tsd_cli.options.robot import SimulatedRobotOptions
from tsd_cli.options.services import ServiceOptions


@with_groups
def calibrate(
    calibration: CalibrationOptions,
    body: SimulatedRobotOptions,
    services: ServiceOptions,
    output: JsonOptions,
) -> None:
    """Correct the centre of mass from centres of pressure of static poses.

    A controller with wrong masses regulates the wrong point: learning takes away
    the error it sees and leaves that of the true centre of mass. Standing still,
    the centre of mass is straight above the centre of pressure; poses that lean
    differently give its height as well.

      tsd calibrate --link-error 0.1 --out com.json
      tsd learn squat --link-error 0.1 --com-correction com.json
    """
    from tsd_cli.actions.calibrate import correct_center_of_mass

    correct_center_of_mass(calibration, body, services, output)
