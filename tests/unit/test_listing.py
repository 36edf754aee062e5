from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.wire.listing import LARGEST_PAGE, Listing

NUMBERS = st.none() | st.integers(0, 10**18 - 1)


@given(
    st.none() | st.sampled_from(["squat", "my_motion.2"]),
    st.integers(1, LARGEST_PAGE),
    NUMBERS,
    NUMBERS,
)
def test_a_listing_survives_being_written(
    motion: str | None, limit: int, after: int | None, forget: int | None
) -> None:
    listing = Listing(motion, limit, after, forget)
    assert Listing.of(listing.texts()) == listing


def test_without_fields_it_is_the_largest_page() -> None:
    assert Listing.of({}) == Listing(None, LARGEST_PAGE, None, None)


@pytest.mark.parametrize(
    ("texts", "said"),
    [
        ({"limit": "0"}, f"1 to {LARGEST_PAGE}"),
        ({"limit": str(LARGEST_PAGE + 1)}, f"1 to {LARGEST_PAGE}"),
        ({"limit": "many"}, "number of entries"),
        ({"after": "-1"}, "number of an entry"),
        ({"forget": "1" * 19}, "number of an entry"),
        ({"motion": "a b"}, "letters"),
        ({"robot": "h"}, "motion, limit, after, forget"),
    ],
)
def test_what_makes_no_sense_is_refused(texts: dict[str, str], said: str) -> None:
    with pytest.raises(InvalidValue, match=said):
        Listing.of(texts)
