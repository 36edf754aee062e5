"""Inertial parameters identified from motion data, the alternative to learning."""
