"""Pictures of the simulated robot, rendered without a screen."""
