from __future__ import annotations

import pytest

from tsd_casadi.learning.circumstances import Circumstances, tell_differences


def test_the_hardware_is_what_a_setting_says_of_the_robot() -> None:
    setting = {"model_error": 0.1, "hardware": ["lag"], "period_s": 1e-3, "seed": 4}
    assert Circumstances({}, setting).hardware == {"model_error": 0.1, "hardware": ["lag"]}


@pytest.mark.parametrize(
    ("hardware", "told"),
    [
        ([], ""),
        ([{"model_error": 0.1}], ""),
        ([{"model_error": 0.1}, {"model_error": 0.1}], ""),
        # a real robot says nothing of itself
        ([{"model_error": 0.1}, {}], ""),
        ([{"model_error": 0.1}, {"model_error": 0.2}], "model_error 0.1 or 0.2"),
        (
            [{"model_error": 0.1, "hardware": []}, {"model_error": 0.1, "hardware": ["lag"]}] * 2,
            "hardware [] or ['lag']",
        ),
        ([{"model_error": 0}, {"model_error": 0, "link_error": 0.1}], "link_error none or 0.1"),
    ],
)
def test_robots_that_differ_are_told_by_what_differs(
    hardware: list[dict[str, object]], told: str
) -> None:
    assert tell_differences(hardware) == told
