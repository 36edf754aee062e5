"""The contacts that a robot file asks for."""

from __future__ import annotations

from tsd_casadi.formulation.contact import Contact
from tsd_casadi.formulation.point_contact import PointContact
from tsd_casadi.formulation.sole_contact import SoleContact
from tsd_casadi.robot.robot import Robot
from tsd_casadi.robot.robot_file_sections import SoleFile


def make_contacts(robot: Robot) -> list[Contact]:
    """Make the contacts that a robot's file asks for.

    Returns:
        One contact per entry, in the file's order.
    """
    contacts: list[Contact] = []
    for file in robot.description.contacts:
        frame = robot.frame_name(file.name)
        if isinstance(file, SoleFile):
            contacts.append(SoleContact(file, frame))
        else:
            contacts.append(PointContact(file, frame))
    return contacts
