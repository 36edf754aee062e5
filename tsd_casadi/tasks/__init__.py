"""Cartesian tasks: what the controller is asked to track."""
