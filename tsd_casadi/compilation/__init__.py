"""From the formulation to a shared library: C is generated, compiled once and kept."""
