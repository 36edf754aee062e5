from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tsd_casadi.exceptions import MalformedMessage
from tsd_casadi.wire.latency import BOUNDS, LatencyHistogram, LatencyMessage

durations = st.lists(st.floats(1e-7, 100.0), min_size=1, max_size=50)


@given(durations, st.floats(0.01, 1.0))
def test_a_quantile_is_the_bound_above_the_true_one(seconds: list[float], share: float) -> None:
    histogram = LatencyHistogram()
    for each in seconds:
        histogram.add(each)
    found = histogram.message().quantile(share)
    assert found is not None
    true = 1e6 * float(np.quantile(seconds, share, method="inverted_cdf"))
    assert true <= found
    assert found == float("inf") or found == BOUNDS[0] or found / 2 < true * (1 + 1e-12)


def test_a_duration_on_a_bound_belongs_below_it() -> None:
    histogram = LatencyHistogram()
    histogram.add(BOUNDS[3] / 1e6)
    histogram.add(BOUNDS[-1] / 1e6 * 1.01)
    counts = histogram.message().counts
    assert counts[3] == 1
    assert counts[-1] == 1
    assert sum(counts) == 2


def test_without_any_there_is_no_quantile() -> None:
    assert LatencyHistogram().message().quantile(0.5) is None


def test_counts_have_to_fit_the_bounds() -> None:
    with pytest.raises(MalformedMessage):
        LatencyMessage.decode(b'{"bounds": [1, 2], "counts": [1, 2]}')
