"""What is never mixed, what starts anew, and what only separates errors."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tsd_casadi.database.database import Database
from tsd_casadi.encoding.laps import Lap
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.exceptions import EntryNotFound
from tsd_casadi.learning.axis_error import AxisError
from tsd_casadi.learning.circumstances import Circumstances
from tsd_casadi.learning.context import Context
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.recording import Recording
from tsd_casadi.motions.declaration import Declaration
from tsd_casadi.motions.parameter import Parameter

BASIS = PeriodicBasis()
PHASE = np.linspace(0, 2 * np.pi, 100, endpoint=False)
CONTEXT = Context("00ff", "abcd")
OTHERS = [
    replace(CONTEXT, body="beef"),
    replace(CONTEXT, formulation="beef"),
    replace(CONTEXT, correction="beef"),
]
IDEAL = {"model_error": 0.1, "hardware": []}
SQUAT = {"amplitude": 0.05, "frequency": 0.25}
PLACES = [(0.02, 0.25), (0.04, 0.25), (0.06, 0.25), (0.08, 0.25)]


def recording(
    amplitude: float = 0.05,
    frequency: float = 0.25,
    context: Context = CONTEXT,
    sign: float = 1.0,
    P: float = 50.0,
    error: float = 1e-3,
    setting: dict[str, Any] | None = None,
    **changes: Any,
) -> Recording:
    signal = sign * (0.7 + amplitude * np.sin(PHASE))[None, :]
    parameters = {"amplitude": amplitude, "frequency": frequency}
    made = Recording(
        key=EntryKey.of("r", "squat", "1", ("com.z",), parameters, context),
        basis=BASIS,
        applied=np.zeros((1, BASIS.L)),
        laps=[Lap(PHASE, signal)] * 2,
        errors={"com.z": AxisError(error)},
        circumstances=Circumstances({"P": [P], "D": [14.0]}, setting or {}, "test"),
        declaration=Declaration(
            "squat", "1", (Parameter("amplitude", "m"), Parameter("frequency", "Hz"))
        ),
    )
    return replace(made, **changes)


@pytest.fixture
def database(tmp_path: Path) -> Iterator[Database]:
    with Database(tmp_path / "d.sqlite") as opened:
        yield opened


@pytest.mark.parametrize("other", OTHERS)
def test_entries_of_another_context_beside_the_query_change_nothing(
    database: Database, other: Context
) -> None:
    for place in PLACES:
        database.record(recording(*place))
    alone = database.query("squat", context=CONTEXT, **SQUAT)
    # the opposite sign, nearer to what is asked for, recorded last
    for amplitude in (0.049, 0.05, 0.051):
        database.record(recording(amplitude, context=other, sign=-1.0))
    beside = database.query("squat", context=CONTEXT, **SQUAT)
    np.testing.assert_array_equal(beside.weights, alone.weights)
    assert (beside.kind, beside.provenance["others"]) == ("generalised", 3)
    assert beside.provenance["context"] == asdict(CONTEXT)
    # whoever asks for them gets them, and is told what they are of
    forced = database.query("squat", context=other, **SQUAT)
    assert forced.mean([0.0])[0, 0] < 0 < beside.mean([0.0])[0, 0]
    assert (forced.provenance["context"], forced.provenance["others"]) == (asdict(other), 4)


def test_another_robot_is_never_asked(database: Database) -> None:
    for place in PLACES:
        made = recording(*place, sign=-1.0)
        database.record(replace(made, key=replace(made.key, robot="another")))
    with pytest.raises(EntryNotFound):
        database.query("squat", robot="r", **SQUAT)
    database.record(recording())
    assert database.query("squat", robot="r", **SQUAT).mean([0.0])[0, 0] > 0
    with pytest.raises(EntryNotFound, match="name the robot"):
        database.query("squat", **SQUAT)


def test_another_hardware_of_a_simulation_starts_an_epoch_of_the_same_entry(
    database: Database,
) -> None:
    first, _ = database.record(recording(setting=IDEAL, error=1e-6))
    loaded = {**IDEAL, "model_error": 0.03}
    applied = first.served.weights
    entry, notes = database.record(
        recording(setting=loaded, applied=applied, error=1e-2, sign=-0.5)
    )
    assert entry.identifier == first.identifier
    assert entry.epoch == 1
    assert any("'model_error': 0.03" in note and "Epoch 1" in note for note in notes)
    # what was better with the robot of before is no reason to go back to it
    assert entry.served.learned_from == entry.iterations[-2].number
    assert (entry.served.epoch, entry.learning_gain) == (1, 1.0)
    assert database.query("squat", **SQUAT).provenance["epoch"] == 1
    # once more with the same, and nothing starts again
    again, _ = database.record(
        recording(setting=loaded, applied=entry.served.weights, error=1e-3, sign=0.0)
    )
    assert again.epoch == 1


@pytest.mark.parametrize(
    "change", [{"seed": 7}, {"transport": "zenoh"}, {"p_scale": 0.2}, {"pace": 1.0}]
)
def test_what_says_nothing_of_the_robot_starts_no_epoch(
    database: Database, change: dict[str, Any]
) -> None:
    database.record(recording(setting=IDEAL))
    entry, _ = database.record(recording(setting={**IDEAL, **change}))
    assert entry.epoch == 0


@pytest.mark.parametrize("settings", [({}, IDEAL), (IDEAL, {})])
def test_hardware_that_nobody_wrote_down_starts_no_epoch(
    database: Database, settings: tuple[dict[str, Any], dict[str, Any]]
) -> None:
    for setting in settings:
        entry, _ = database.record(recording(setting=setting))
    assert entry.epoch == 0


def test_a_recording_without_hardware_does_not_hide_that_of_before(database: Database) -> None:
    applied = np.zeros((1, BASIS.L))
    epochs = []
    for setting in (IDEAL, {}, IDEAL, {}, {**IDEAL, "model_error": 0.03}):
        entry, _ = database.record(recording(setting=setting, applied=applied, sign=0.0))
        applied = applied + 1e-3
        epochs.append(entry.epoch)
    assert epochs == [0, 0, 0, 0, 1]


def test_gains_separate_errors_but_not_what_is_served(database: Database) -> None:
    stiff, _ = database.record(recording(P=50.0, error=1e-3))
    served = database.query("squat", **SQUAT)
    # the same entry answers whatever the gains of who asks, and takes in what they did
    soft, notes = database.record(recording(P=10.0, applied=served.weights, error=5e-3, sign=0.0))
    assert soft.identifier == stiff.identifier
    assert any("gains differ" in note for note in notes)
    # ten times the error at a fifth of the stiffness is not worse than what P = 50 left
    assert soft.best.gains == {"P": [10.0], "D": [14.0]}
    assert database.query("squat", **SQUAT).provenance["gains"]["P"] == [10.0]


def test_a_payload_is_a_parameter_where_the_user_says_so(database: Database) -> None:
    declaration = Declaration(
        "carry", "1", (Parameter("frequency", "Hz"), Parameter("payload", "kg", default=0.0))
    )

    def carried(payload: float) -> Recording:
        made = recording(
            laps=[Lap(PHASE, (0.1 * payload + 0.01 * np.sin(PHASE))[None, :])] * 2,
            declaration=declaration,
        )
        parameters = {"frequency": 0.25, "payload": payload}
        key = EntryKey.of("r", "carry", "1", ("com.z",), parameters, CONTEXT)
        # the hardware changes with the payload; each has an entry of its own
        setting = Circumstances(made.circumstances.gains, {**IDEAL, "model_error": payload})
        return replace(made, key=key, circumstances=setting)

    entries = [database.record(carried(kilograms))[0] for kilograms in (0.0, 2.0, 4.0, 6.0)]
    assert len({entry.identifier for entry in entries}) == 4
    assert {entry.epoch for entry in entries} == {0}
    found = database.query("carry", frequency=0.25, payload=3.0)
    assert found.kind == "generalised"
    assert found.mean([0.0])[0, 0] == pytest.approx(0.3, abs=0.05)
