"""The alternatives themselves: integral action, observer, joint torques, identification."""
