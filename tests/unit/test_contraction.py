from __future__ import annotations

import json
from dataclasses import asdict

import numpy as np
import pytest

from tsd_casadi.learning.contraction import Contraction
from tsd_casadi.learning.learning_filter import design_filter
from tsd_casadi.learning.loop_response import LoopResponse

RESPONSE = LoopResponse(0.95, 0.03, 0.05, 0.012)
OMEGA = 2 * np.pi * np.arange(13.0)
FILTER = design_filter(RESPONSE, OMEGA, 50.0, 14.0)
OBSERVED = np.where(np.arange(13) < 5, 0.3, np.nan)


def test_the_account_is_that_of_the_filter() -> None:
    account = Contraction.of("com.z", 1.0, FILTER, 1.0, OBSERVED)
    assert account.frequency == tuple(range(13))
    assert account.plain == tuple(FILTER.plain_contraction)
    assert account.observed == (*[0.3] * 5, *[None] * 8)
    assert (account.gain, account.delay) == (0.95, 0.03)
    assert (account.gain_deviation, account.delay_deviation) == (0.05, 0.012)
    assert (account.lead, account.bandwidth) == (FILTER.lead, FILTER.bandwidth)


def test_nothing_is_predicted_where_nothing_is_learned() -> None:
    account = Contraction.of("com.z", 1.0, FILTER, 1.0, OBSERVED)
    learned = [value is not None for value in account.predicted]
    assert learned == (FILTER.Q > 0).tolist()
    assert not all(learned)


@pytest.mark.parametrize("gain", [1.0, 0.5, 0.125])
def test_a_share_of_the_change_leaves_the_rest_of_the_error(gain: float) -> None:
    account = Contraction.of("com.z", 1.0, FILTER, gain, OBSERVED)
    possible = [
        np.abs(1 - gain * FILTER.L * LoopResponse(a, tau).transfer(OMEGA, 50.0, 14.0))
        for a in (0.85, 0.95, 1.05)
        for tau in (0.006, 0.03, 0.054)
    ]
    worst = np.max(possible, axis=0)
    for harmonic, predicted in enumerate(account.predicted):
        if predicted is not None:
            assert worst[harmonic] <= predicted + 1e-9 < 1
    assert account.predicted[0] == pytest.approx(1 - gain)


def test_it_is_plain_data() -> None:
    account = Contraction.of("com.z", 1.0, FILTER, 1.0, OBSERVED)
    plain = json.loads(json.dumps(asdict(account), allow_nan=False))
    assert plain["observed"][:6] == [0.3] * 5 + [None]
