"""MuJoCo as a plant: wrong masses, real hardware's effects, pushes, static poses."""
