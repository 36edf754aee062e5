from __future__ import annotations

import pytest
import zenoh

from tsd_casadi.exceptions import InvalidValue, MalformedMessage
from tsd_casadi.wire import keys

ROBOT = "hermes_lower"
ALL = {
    "tsd/hermes_lower/controller/tick": keys.tick_key(ROBOT),
    "tsd/hermes_lower/controller/info": keys.info_key(ROBOT),
    "tsd/hermes_lower/learner/feedforward": keys.feedforward_key(ROBOT),
    "tsd/hermes_lower/learner/suggestion": keys.suggestion_key(ROBOT),
    "tsd/hermes_lower/learner/record": keys.record_key(ROBOT),
    "tsd/hermes_lower/learner/database": keys.database_key(ROBOT),
    "tsd/hermes_lower/controller/alive": keys.alive_key(ROBOT, "controller"),
    "tsd/hermes_lower/learner/alive": keys.alive_key(ROBOT, "learner"),
}


@pytest.mark.parametrize("documented", ALL)
def test_keys_are_the_documented_ones(documented: str) -> None:
    assert ALL[documented] == documented


@pytest.mark.parametrize("key", ALL)
def test_keys_are_valid_zenoh_keys_in_canonical_form(key: str) -> None:
    assert str(zenoh.KeyExpr(key)) == key


@pytest.mark.parametrize("key", ALL)
def test_the_robot_is_its_own_chunk(key: str) -> None:
    assert keys.robot_of(key) == ROBOT
    chunks = key.split("/")
    assert len(chunks) == 4
    assert chunks[1] == ROBOT


@pytest.mark.parametrize(
    "make",
    [
        keys.feedforward_key,
        keys.suggestion_key,
        keys.record_key,
        keys.database_key,
        keys.tick_key,
    ],
)
def test_any_robot_matches_every_robot(make: object) -> None:
    assert callable(make)
    every = zenoh.KeyExpr(make(keys.ANY_ROBOT))
    assert every.intersects(zenoh.KeyExpr(make(ROBOT)))
    assert every.includes(zenoh.KeyExpr(make("another")))


def test_no_two_keys_meet() -> None:
    for one in ALL:
        for other in ALL:
            meets = zenoh.KeyExpr(one).intersects(zenoh.KeyExpr(other))
            assert meets == (one == other)


def test_keys_of_a_run_are_its_own() -> None:
    made = [keys.rows_key, keys.events_key, keys.story_key, keys.run_alive_key]
    assert [make(ROBOT, 0x1F) for make in made] == [
        f"tsd/hermes_lower/run/1f/{word}" for word in ("rows", "events", "story", "alive")
    ]
    for make in made:
        key = make(ROBOT, 2**63)
        assert str(zenoh.KeyExpr(key)) == key
        assert not zenoh.KeyExpr(key).intersects(zenoh.KeyExpr(make(ROBOT, 1)))
        assert keys.robot_of(key) == ROBOT


@pytest.mark.parametrize("robot", ["", "a/b", "**", "a*", "$*", "a#b", "a?b=1", "@a", "/"])
def test_what_cannot_be_a_chunk_is_no_robot(robot: str) -> None:
    with pytest.raises(InvalidValue, match="the name of a robot"):
        keys.tick_key(robot)


def test_a_key_without_a_robot_is_told() -> None:
    with pytest.raises(MalformedMessage, match="tsd/<robot>"):
        keys.robot_of("tsd")
