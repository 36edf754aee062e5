"""What the 3D view shows, as its user chose."""

from __future__ import annotations

import viser

from tsd_clients.viewer import contact_marks, mass_marks, robot_body

Color = tuple[int, int, int]


class ViewChoice:
    """Boxes to tick, each with the colour of what it shows."""

    def __init__(self, gui: viser.GuiApi) -> None:
        """Add the boxes."""
        gui.add_html(
            "<div style='font-size:13px;line-height:1.8;padding:0 10px 8px'>"
            + _key("&#8593;", contact_marks.FORCE, "contact force that the controller plans")
            + _key("&#9644;", contact_marks.ON, "foot that presses on the ground, support polygon")
            + _key("&#9644;", contact_marks.OFF, "foot that does not")
            + _key("&#9679;", contact_marks.PRESSURE, "centre of pressure")
            + _key("&#9679;", mass_marks.ESTIMATED, "centre of mass, as the controller sees it")
            + _key("&#9679;", mass_marks.TRUE, "true centre of mass, where it is known")
            + _key("&#9679;", mass_marks.REFERENCE, "centre of mass of the reference")
            + _key("&#9608;", robot_body.GHOST, "posture of the reference")
            + "</div>"
        )
        self._forces = gui.add_checkbox("contact forces", True)
        self._support = gui.add_checkbox("feet and support", True)
        self._mass = gui.add_checkbox("centre of mass", True)
        self._ghost = gui.add_checkbox("reference", True)
        self._see_through = gui.add_checkbox("see through the robot", False)
        self.shadows = gui.add_checkbox(
            "shadows", False, hint="slow in a browser without a graphics card"
        )

    @property
    def forces(self) -> bool:
        """Whether contact forces are shown."""
        return bool(self._forces.value)

    @property
    def support(self) -> bool:
        """Whether feet, support polygon and centre of pressure are shown."""
        return bool(self._support.value)

    @property
    def mass(self) -> bool:
        """Whether centres of mass are shown."""
        return bool(self._mass.value)

    @property
    def see_through(self) -> bool:
        """Whether what is inside of the robots is seen."""
        return bool(self._see_through.value)

    @property
    def ghost(self) -> bool:
        """Whether the reference's posture is shown."""
        return bool(self._ghost.value)


def _key(sign: str, color: Color, meaning: str) -> str:
    return f"<span style='color:rgb{color}'>{sign}</span> {meaning}<br>"
