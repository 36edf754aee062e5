"""Rows of the QP: contact accelerations and the inequalities of section III, one module each."""
