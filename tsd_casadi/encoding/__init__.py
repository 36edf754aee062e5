"""Signals over the phase [phi_omega]: periodic basis [basis_functions, psi], harmonics, laps."""
