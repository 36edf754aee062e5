"""The compiled controller, loaded: state and command in, torque out."""
