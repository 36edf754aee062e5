"""Links and joints as their author wrote them, URDF or MJCF: read, expanded, not yet a model."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal
from xml.etree import ElementTree

from tsd_casadi.exceptions import RobotFileError

# the largest of the public descriptions has 200 kB
LARGEST_FILE = 10_000_000  # bytes
XACRO = "{http://www.ros.org/wiki/xacro}"
# a URDF joint of these types moves and needs limits
LIMITED = ("revolute", "prismatic")
CONTINUOUS = "continuous"

Kind = Literal["urdf", "mjcf"]


@dataclass(frozen=True)
class Description:
    """A description's XML.

    Attributes:
        path: Its file.
        kind: 'urdf' or 'mjcf'.
        root: Its root element.
        expanded: Whether it was xacro, so that the file alone does not tell it all.
    """

    path: Path
    kind: Kind
    root: ElementTree.Element
    expanded: bool = False

    @property
    def text(self) -> str:
        """The XML, to be parsed."""
        return ElementTree.tostring(self.root, encoding="unicode")

    def links(self) -> dict[str, ElementTree.Element]:
        """Find the links by name."""
        tag = "link" if self.kind == "urdf" else "body"
        return {link.get("name", ""): link for link in self.root.iter(tag)}

    def joints(self) -> dict[str, ElementTree.Element]:
        """Find the joints of a URDF by name, fixed ones too; an MJCF's with a name."""
        found = self.root.findall("joint") if self.kind == "urdf" else self.root.iter("joint")
        return {joint.get("name", ""): joint for joint in found if joint.get("name")}

    def leader_of(self, joint: str) -> str | None:
        """Name the joint that another one mimics, None if it moves by itself."""
        if self.kind == "urdf":
            element = self.joints().get(joint)
            mimic = None if element is None else element.find("mimic")
            return None if mimic is None else mimic.get("joint")
        for equality in self.root.findall("equality/joint"):
            if equality.get("joint1") == joint:
                return equality.get("joint2")
        return None


def read_description(path: Path, kind: Kind) -> Description:
    """Read a description.

    Raises:
        RobotFileError: If it cannot be read, is too large, no XML of that kind, or
            xacro that cannot be expanded here.
    """
    root = _parse(path)
    expanded = _is_xacro(path, root)
    if expanded:
        root = _expand(path)
    wanted = "robot" if kind == "urdf" else "mujoco"
    if root.tag != wanted:
        found = {"robot": "a URDF", "mujoco": "an MJCF"}.get(root.tag, f"<{root.tag}>")
        hint = "; name it as 'mjcf'" if root.tag == "mujoco" else ""
        hint = "; name it as 'urdf'" if root.tag == "robot" else hint
        raise RobotFileError(path, "", f"is {found}", f"the element <{wanted}> at its root{hint}")
    return Description(path, kind, root, expanded)


def kind_of(path: Path) -> Kind:
    """Tell URDF from MJCF by what is in the file.

    Raises:
        RobotFileError: If it cannot be read or is neither.
    """
    root = _parse(path)
    if root.tag not in ("robot", "mujoco"):
        raise RobotFileError(path, "", f"has <{root.tag}> at its root", "a URDF or an MJCF")
    return "urdf" if root.tag == "robot" else "mjcf"


def _parse(path: Path) -> ElementTree.Element:
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST_FILE + 1)
    except OSError as error:
        raise RobotFileError(path, "", f"cannot be read ({error})", "a URDF or MJCF") from error
    if len(content) > LARGEST_FILE:
        expected = f"at most {LARGEST_FILE / 1e6:g} MB; meshes belong into files of their own"
        raise RobotFileError(path, "", "is too large for a description", expected)
    if b"<!ENTITY" in content:
        raise RobotFileError(path, "", "declares XML entities", "them written out")
    try:
        return ElementTree.fromstring(content)
    except ElementTree.ParseError as error:
        raise RobotFileError(
            path, "", f"cannot be parsed as XML ({error})", "a valid URDF or MJCF"
        ) from error


def _is_xacro(path: Path, root: ElementTree.Element) -> bool:
    return path.suffix == ".xacro" or any(
        str(element.tag).startswith(XACRO) for element in root.iter()
    )


def _expand(path: Path) -> ElementTree.Element:
    try:
        import xacro
    except ImportError as error:
        raise RobotFileError(
            path,
            "",
            "is xacro, and the package that expands it is not there",
            f"'pip install xacro', or the URDF that 'xacro {path.name} > robot.urdf' writes",
        ) from error
    try:
        return ElementTree.fromstring(xacro.process_file(str(path)).toxml())
    except Exception as error:  # its own, those of XML and of the expressions in it
        reason = " ".join(str(error).split()) or type(error).__name__
        raise RobotFileError(
            path,
            "",
            f"cannot be expanded as xacro ({reason})",
            "xacro that needs no ROS: $(find package) and launch arguments do not work here",
        ) from error
