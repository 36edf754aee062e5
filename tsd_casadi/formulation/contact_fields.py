"""A foot on the ground: its part of the command."""

from __future__ import annotations

from tsd_casadi.robot.robot import Robot
from tsd_casadi.robot.robot_file_sections import Contact
from tsd_casadi.tick.layout import Field


def contact_fields(contact: Contact, robot: Robot) -> tuple[Field, ...]:
    """Describe the command's fields of one contact, with the robot's defaults.

    Returns:
        The fields; the wanted wrench shares the weight between all contacts.
    """
    name = contact.name
    share = robot.weight / len(robot.description.contacts)
    weights = robot.description.regularization
    return (
        Field(
            f"{name}.active",
            1,
            "1",
            "1: in contact, 0: free, its wrench is zero",
            default=(1.0,),
            switch=True,
        ),
        Field(
            f"{name}.friction",
            1,
            "1",
            "Coulomb coefficient",
            lower=0.0,
            default=(contact.friction,),
        ),
        Field(
            f"{name}.torsional_friction",
            1,
            "m",
            "bound of |normal torque| / normal force",
            lower=0.0,
            default=(contact.torsional_friction,),
        ),
        Field(
            f"{name}.extents",
            4,
            "m",
            "sole: x low, x high, y low, y high, sole frame",
            default=(*contact.x, *contact.y),
        ),
        Field(
            f"{name}.minimum_force",
            1,
            "N",
            "least normal force while in contact",
            lower=0.0,
            default=(contact.minimum_force,),
        ),
        Field(
            f"{name}.lambda_des",
            6,
            "N, N m",
            "wanted wrench [force; moment], sole frame",
            default=(0.0, 0.0, share, 0.0, 0.0, 0.0),
        ),
        Field(
            f"{name}.W_lambda",
            6,
            "1/N^2, 1/(N m)^2",
            "diagonal of the weight on the wrench",
            lower=0.0,
            default=(weights.force,) * 3 + (weights.moment,) * 3,
        ),
    )
