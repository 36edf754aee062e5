r"""The acceleration a task asks for [des_cart_acc, task_specific_dynamics].

.. math::

    \ddot x_{des} = \ddot x_{ref} + \ddot x_{ff} +
        \underbrace{P (x_{ref} - x) + D (\dot x_{ref} - \dot x)}_{feedback}

where :math:`\ddot x_{ff}` is the learned term, :math:`\ddot x_{fb,i-1}` in the
paper.
"""

from __future__ import annotations

import casadi as ca


def feedback_acceleration(P: ca.SX, error: ca.SX, D: ca.SX, error_rate: ca.SX) -> ca.SX:
    """Compute what the feedback adds, the signal that is learned from.

    Args:
        P: Stiffness, (k, k) [1/s^2].
        error: x_ref - x, (k,) [m or rad], world axes.
        D: Damping, (k, k) [1/s].
        error_rate: xd_ref - xd, (k,) [m/s or rad/s], world axes.

    Returns:
        (k,) [m/s^2 or rad/s^2].
    """
    return P @ error + D @ error_rate


def desired_acceleration(reference: ca.SX, feedforward: ca.SX, feedback: ca.SX) -> ca.SX:
    """Add up reference, learned term and feedback.

    Args:
        reference: xdd_ref, (k,) [m/s^2 or rad/s^2].
        feedforward: Learned term, (k,), same unit.
        feedback: Feedback term, (k,), same unit.

    Returns:
        xdd_des, (k,).
    """
    return reference + feedforward + feedback
