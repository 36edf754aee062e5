from __future__ import annotations

from xml.etree import ElementTree

import pytest

from tsd_casadi.robot.mjcf_efforts import mjcf_efforts


def efforts(actuators: str, *, defaults: str = "", joint: str = "", body: str = "") -> object:
    text = (
        f"<mujoco>{defaults}<worldbody><body {body}><joint name='a' {joint}/></body></worldbody>"
        f"<actuator>{actuators}</actuator></mujoco>"
    )
    return mjcf_efforts(ElementTree.fromstring(text)).get("a")


@pytest.mark.parametrize(
    ("actuators", "expected"),
    [
        ("", None),
        ("<motor joint='a'/>", None),
        ("<motor joint='a' ctrlrange='-30 30'/>", 30.0),
        ("<motor joint='a' ctrlrange='-30 20'/>", 20.0),
        ("<motor joint='a' ctrlrange='-3 3' gear='10'/>", 30.0),
        ("<motor joint='a' ctrlrange='-30 30' forcerange='-25 25'/>", 25.0),
        ("<position joint='a' ctrlrange='-1 1' forcerange='-25 25'/>", 25.0),
        ("<general joint='a' forcerange='-2 2' gear='-5 0 0 0 0 0'/>", 10.0),
        ("<motor joint='b' ctrlrange='-30 30'/>", None),
    ],
)
def test_an_actuator_bounds_its_joint(actuators: str, expected: float | None) -> None:
    assert efforts(actuators) == expected


def test_a_joint_bounds_itself() -> None:
    assert efforts("", joint="actuatorfrcrange='-7 7'") == 7.0
    assert efforts("<motor joint='a' ctrlrange='-5 5'/>", joint="actuatorfrcrange='-7 7'") == 5.0
    assert efforts("<motor joint='a' ctrlrange='-9 9'/>", joint="actuatorfrcrange='-7 7'") == 7.0


DEFAULTS = (
    "<default><motor ctrlrange='-1 1'/><default class='big'><motor ctrlrange='-2 2'/>"
    "<joint actuatorfrcrange='-20 20'/><default class='bigger'><motor gear='3'/></default>"
    "</default></default>"
)


@pytest.mark.parametrize(
    ("actuator", "joint", "body", "expected"),
    [
        ("<motor joint='a'/>", "", "", 1.0),
        ("<motor joint='a' class='big'/>", "", "", 2.0),
        ("<motor joint='a' class='bigger'/>", "", "", 6.0),
        ("", "class='big'", "", 20.0),
        ("", "", "childclass='big'", 20.0),
        ("", "class='bigger'", "", 20.0),
    ],
)
def test_classes_hand_down_what_is_left_out(
    actuator: str, joint: str, body: str, expected: float
) -> None:
    assert efforts(actuator, defaults=DEFAULTS, joint=joint, body=body) == expected
