from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tsd_experiments.harness.duration import LONGEST_PAUSE, time_taken

SPANS = st.lists(
    st.tuples(st.integers(0, 500), st.integers(1, 50)).map(lambda s: (s[0], s[0] + s[1])),
    min_size=1,
)


def test_side_by_side_counts_once() -> None:
    assert time_taken([(0.0, 10.0), (0.0, 8.0), (4.0, 12.0)]) == 12.0


def test_what_lies_between_two_sittings_does_not_count() -> None:
    assert time_taken([(1000.0, 1010.0), (0.0, 10.0)]) == 20.0


def test_short_pauses_count() -> None:
    assert time_taken([(0.0, 10.0), (10.0 + LONGEST_PAUSE, 50.0)]) == 50.0


def test_no_jobs_take_no_time() -> None:
    assert time_taken([]) == 0.0


@given(spans=SPANS)
def test_it_is_the_number_of_seconds_in_which_something_ran(
    spans: list[tuple[int, int]],
) -> None:
    busy = np.zeros(600, dtype=bool)
    for begin, end in spans:
        busy[begin:end] = True
    edges = np.flatnonzero(np.diff(busy.astype(int)))
    # the idle stretches between busy ones
    for stop, begin in pairwise(edges):
        if not busy[stop + 1] and busy[stop] and begin - stop <= LONGEST_PAUSE:
            busy[stop + 1 : begin + 1] = True
    assert time_taken([(float(a), float(b)) for a, b in spans]) == pytest.approx(busy.sum())
