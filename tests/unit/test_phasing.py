from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lsim

from tsd_casadi.repetition.phasing import FADE, PhasedShare, settling_time


def test_a_share_is_level_where_a_change_begins_and_ends() -> None:
    share = PhasedShare(0.0)
    assert share.at(7.0) == 0.0
    share.go_to(1.0, 7.0, 2.0)
    shares = np.array([share.at(time) for time in np.linspace(7, 10, 301)])
    assert (np.diff(shares) >= 0).all()
    assert shares[[0, 100, 200, 300]] == pytest.approx([0, 0.5, 1, 1])
    assert np.diff(shares)[[0, 199]] == pytest.approx(0, abs=1e-4)
    # no faster than 3/2 of what a ramp would be
    assert np.diff(shares).max() <= 1.5 * 0.01 / 2 + 1e-9


def test_a_change_begins_where_the_one_before_got_to() -> None:
    share = PhasedShare(0.0)
    share.go_to(1.0, 0.0, 4.0)
    half = share.at(2.0)
    share.go_to(0.0, 2.0, FADE)
    assert share.at(2.0) == half == 0.5
    assert share.at(2.0 + FADE / 2) == pytest.approx(0.25)
    assert share.at(9.0) == 0.0


@pytest.mark.parametrize("stiffness", [5.0, 50.0])
@pytest.mark.parametrize("ratio", [0.3, 1.0, 2.0])
def test_a_loop_has_answered_once_it_has_settled(stiffness: float, ratio: float) -> None:
    """Against SciPy's own simulation of s^2 + D s + P, driven by a change of two seconds."""
    damping = 2 * ratio * np.sqrt(stiffness)
    share, time = PhasedShare(0.0), np.linspace(0, 60, 12_001)
    share.go_to(1.0, 0.0, 2.0)
    u = [share.at(each) for each in time]
    _, answer, _ = lsim(([stiffness], [1.0, damping, stiffness]), u, time)
    settled = 2.0 + settling_time(np.array([stiffness]), np.array([damping]))
    assert settled < 2.0 + 30 / np.sqrt(stiffness)
    assert np.abs(answer - 1)[time >= settled].max() < 2e-2


def test_the_slowest_axis_counts() -> None:
    slow, fast = (settling_time(np.array([P]), np.array([2 * np.sqrt(P)])) for P in (5.0, 500.0))
    both = settling_time(np.array([500.0, 5.0, 0.0]), 2 * np.sqrt([500.0, 5.0, 0.0]))
    assert fast < 0.2 * slow
    assert both == pytest.approx(slow)


def test_what_is_not_damped_never_settles() -> None:
    assert settling_time(np.array([50.0]), np.array([0.0])) == np.inf
