"""Learning on a robot that shakes, and on one that is not the same tomorrow."""
