from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tsd_casadi.exceptions import TsdError, UnknownField
from tsd_casadi.tick.layout import HUGE, Field, Layout, hash_layouts

POSE = Field("pose", 7, "m, 1", "a pose", default=(1, 2, 3, 0, 0, 0, 1), unit_quaternion=3)
GAIN = Field("gain", 2, "1/s", "a gain", lower=0.0, upper=10.0, default=(4.0, 5.0))
SWITCH = Field("switch", 1, "1", "a switch", default=(1.0,), switch=True)
LAYOUT = Layout((GAIN, POSE, SWITCH))


def test_fields_follow_each_other() -> None:
    assert LAYOUT.size == 10
    assert [LAYOUT.slice(field.name) for field in LAYOUT] == [
        slice(0, 2),
        slice(2, 9),
        slice(9, 10),
    ]


def test_defaults_and_bounds_are_spread_over_the_fields() -> None:
    np.testing.assert_array_equal(LAYOUT.defaults(), [4, 5, 1, 2, 3, 0, 0, 0, 1, 1])
    np.testing.assert_array_equal(LAYOUT.lower(), [0, 0] + [-HUGE] * 8)
    np.testing.assert_array_equal(LAYOUT.upper(), [10, 10] + [HUGE] * 8)


def test_quaternions_and_switches_are_found() -> None:
    assert LAYOUT.quaternions() == [5]
    assert LAYOUT.switches() == [9]


def test_locate_is_the_inverse_of_slice() -> None:
    for field in LAYOUT:
        place = LAYOUT.slice(field.name)
        for index in range(place.start, place.stop):
            assert LAYOUT.locate(index) == (field, index - place.start)


@pytest.mark.parametrize("index", [-1, 10])
def test_locate_refuses_what_is_outside(index: int) -> None:
    with pytest.raises(IndexError):
        LAYOUT.locate(index)


def test_unknown_field_lists_the_known_ones() -> None:
    with pytest.raises(
        UnknownField, match=r"no field 'gian'; did you mean 'gain'\?; there are"
    ) as told:
        LAYOUT.slice("gian")
    assert told.value.known == ["gain", "pose", "switch"]
    assert isinstance(told.value, KeyError)
    assert isinstance(told.value, TsdError)


@pytest.mark.parametrize("change", [{"name": "other"}, {"size": 3}, {"unit": "1/s^2"}])
def test_hash_follows_names_sizes_and_units(change: dict[str, object]) -> None:
    other = Layout((dataclasses.replace(GAIN, **change), POSE, SWITCH))  # type: ignore[arg-type]
    assert hash_layouts([other]) != hash_layouts([LAYOUT])


def test_hash_follows_order_and_division() -> None:
    swapped = hash_layouts([Layout((POSE, GAIN, SWITCH))])
    divided = hash_layouts([Layout((GAIN,)), Layout((POSE, SWITCH))])
    assert len({swapped, divided, hash_layouts([LAYOUT])}) == 3


def test_hash_does_not_follow_defaults_and_words() -> None:
    other = dataclasses.replace(GAIN, default=(0.0, 0.0), description="another word", upper=1.0)
    assert hash_layouts([Layout((other, POSE, SWITCH))]) == hash_layouts([LAYOUT])


def test_hash_is_the_same_in_every_process_and_fits_64_bits() -> None:
    assert hash_layouts([LAYOUT]) == 8404660856368072722
    assert 0 <= hash_layouts([]) < 2**64
