"""Motions: what the robot is asked to do, with named parameters."""
