"""How far a scene may be from the description before it is another robot."""

from __future__ import annotations

# relative. MuJoCo's XML keeps six digits, which is 5e-6 of a number at worst;
# twenty such numbers along a chain, or a description that was rounded as well,
# stay below this. A mass wrong by a thousandth is ten times above it
TOLERANCE = 1e-4
# of the robot's mass, or of its mass times its height squared: bodies without mass
# of their own are given next to nothing by those who write scenes, relative
NOTHING = 1e-12
