"""What a reply's ``active`` says of a row of the QP."""

from __future__ import annotations

import enum


class RowState(enum.IntEnum):
    """Where a row is; in a reply negative at a lower bound.

    AT_BOUND: at its own bound. YIELDED: a joint's acceleration, whose limits of
    velocity or position do not hold at the next tick because torque, contact or
    acceleration limits do not allow it. AT_POSITION, AT_VELOCITY: a joint's
    acceleration at the bound that its position or velocity makes. AT_SPEED: a joint's
    torque at what its motor has left at its speed. PAST_POSITION, PAST_VELOCITY: that of
    a joint which is past this limit now and comes back faster than it has to. DEPENDENT:
    an equality that follows from others, or nearly so, and is held by them or in part.
    """

    INSIDE = 0
    AT_BOUND = 1
    EQUALITY = 2
    YIELDED = 3
    AT_POSITION = 4
    AT_VELOCITY = 5
    AT_SPEED = 6
    PAST_POSITION = 7
    PAST_VELOCITY = 8
    DEPENDENT = 9


# of rows that are inside or equalities
NO_INEQUALITY = (RowState.INSIDE, RowState.EQUALITY, RowState.DEPENDENT)
# a joint on its stop, or on its way to it or past it
AT_LIMIT = (
    RowState.YIELDED,
    RowState.AT_POSITION,
    RowState.AT_VELOCITY,
    RowState.PAST_POSITION,
    RowState.PAST_VELOCITY,
)
JOINT_ROW = "joint_acceleration"
TORQUE_ROW = "joint_torque"
_NAMED = {
    RowState.AT_POSITION: (JOINT_ROW, "joint_position"),
    RowState.AT_VELOCITY: (JOINT_ROW, "joint_velocity"),
    RowState.PAST_POSITION: (JOINT_ROW, "joint_position"),
    RowState.PAST_VELOCITY: (JOINT_ROW, "joint_velocity"),
    RowState.AT_SPEED: (TORQUE_ROW, "joint_torque_speed"),
}


def name_row(row: str, state: RowState) -> str:
    """Name a row by what makes its bound: 'joint_position.knee'."""
    return row.replace(*_NAMED[state], 1) if state in _NAMED else row
