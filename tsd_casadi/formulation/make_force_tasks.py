"""The tasks of contact forces that a robot file asks for."""

from __future__ import annotations

from collections.abc import Sequence

from tsd_casadi.formulation.contact import Contact
from tsd_casadi.robot.robot import Robot
from tsd_casadi.robot.robot_file_tasks import ContactForceFile
from tsd_casadi.tasks.contact_force_task import ContactForceTask


def make_force_tasks(robot: Robot, contacts: Sequence[Contact]) -> list[ContactForceTask]:
    """Make the tasks of contact forces that a robot's file asks for.

    Returns:
        One task per entry, in the file's order; they ask for each contact's share of the
        weight where nothing is said.
    """
    axes = {contact.name: contact.axes for contact in contacts}
    wanted = (0.0, 0.0, robot.weight / len(contacts), 0.0, 0.0, 0.0)
    return [
        ContactForceTask(part, wanted, axes[part.contact])
        for part in robot.description.all_tasks
        if isinstance(part, ContactForceFile)
    ]
