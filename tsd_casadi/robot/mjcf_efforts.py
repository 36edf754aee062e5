"""Torque limits that an MJCF gives its joints: by its motors, or at the joints."""

from __future__ import annotations

from collections.abc import Iterator
from xml.etree import ElementTree

# actuators whose force at the joint is bounded by what is written at them
ACTUATORS = ("motor", "position", "velocity", "general", "damper")


def mjcf_efforts(root: ElementTree.Element) -> dict[str, float]:
    """Read how large the torque of each joint can be, defaults of classes included.

    What counts is the smallest of the actuator's force range and, for a motor, its
    control range times the gear, and of the joint's own actuatorfrcrange. Lower and
    upper end are taken as symmetric, by the smaller one.

    Args:
        root: The element <mujoco>.

    Returns:
        Torque limit by joint [N m]; joints without one are left out.
    """
    defaults = _Defaults(root)
    efforts: dict[str, float] = {}
    for joint, parent_class in _joints(root):
        name = joint.get("name", "")
        bound = _bound(defaults.value("joint", joint, "actuatorfrcrange", parent_class))
        if bound is not None:
            efforts[name] = bound
    for kind in ACTUATORS:
        for actuator in root.findall(f"actuator/{kind}"):
            name = actuator.get("joint", "")
            gear = (defaults.value(kind, actuator, "gear", None) or "1").split()[0]
            bounds = [_bound(defaults.value(kind, actuator, "forcerange", None))]
            if kind == "motor":
                bounds.append(_bound(defaults.value(kind, actuator, "ctrlrange", None)))
            there = [abs(float(gear)) * bound for bound in bounds if bound is not None]
            if name and there:
                efforts[name] = min(*there, efforts.get(name, there[0]))
    return efforts


def _bound(text: str | None) -> float | None:
    if text is None:
        return None
    low, high = map(float, text.split()[:2])
    return min(abs(low), abs(high))


def _joints(root: ElementTree.Element) -> Iterator[tuple[ElementTree.Element, str | None]]:
    """Find every joint and the class that its body hands down."""

    def below(
        body: ElementTree.Element, handed: str | None
    ) -> Iterator[tuple[ElementTree.Element, str | None]]:
        handed = body.get("childclass", handed)
        for joint in body.findall("joint"):
            yield joint, handed
        for child in body.findall("body"):
            yield from below(child, handed)

    for world in root.findall("worldbody"):
        yield from below(world, None)


class _Defaults:
    """Values that elements leave to their class, or to those that the class is in."""

    def __init__(self, root: ElementTree.Element) -> None:
        self._chains: dict[str | None, list[ElementTree.Element]] = {None: []}
        for default in root.findall("default"):
            self._chains[None] = [default, *self._chains[None]]
        for default in root.findall("default"):
            self._collect(default, self._chains[None])

    def _collect(self, default: ElementTree.Element, outer: list[ElementTree.Element]) -> None:
        for inner in default.findall("default"):
            chain = [inner, *outer]
            self._chains[inner.get("class")] = chain
            self._collect(inner, chain)
        if default.get("class"):
            self._chains.setdefault(default.get("class"), [default])

    def value(
        self, kind: str, element: ElementTree.Element, attribute: str, handed: str | None
    ) -> str | None:
        """Look an attribute up at an element, then at its classes from the inside out."""
        if element.get(attribute) is not None:
            return element.get(attribute)
        chain = self._chains.get(element.get("class", handed or "") or None, self._chains[None])
        for default in chain:
            part = default.find(kind)
            if part is not None and part.get(attribute) is not None:
                return part.get(attribute)
        return None
