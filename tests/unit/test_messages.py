from __future__ import annotations

import json
import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tsd_casadi import Controller
from tsd_casadi.center_of_mass.correction_file import CenterOfMassMessage
from tsd_casadi.document import Document, json_schema
from tsd_casadi.encoding.laps import Lap
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.exceptions import (
    DatabaseError,
    EntryNotFound,
    InvalidValue,
    MalformedMessage,
    OutsideTrainedRange,
    ServiceFailed,
    TsdError,
    UnknownField,
    UnsupportedVersion,
)
from tsd_casadi.generalization.suggestion import Suggestion
from tsd_casadi.learning.axis_error import AxisError
from tsd_casadi.learning.band import Band
from tsd_casadi.learning.circumstances import Circumstances
from tsd_casadi.learning.context import Context
from tsd_casadi.learning.entry import Entry
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.learning.instruction import Instruction
from tsd_casadi.learning.recording import Recording
from tsd_casadi.learning.rules.by_name import find_rule
from tsd_casadi.motions.squat import Squat
from tsd_casadi.wire.axis import AxisErrorMessage, AxisMessage
from tsd_casadi.wire.basis import BasisMessage
from tsd_casadi.wire.context import CircumstancesMessage, ContextMessage
from tsd_casadi.wire.declaration import DeclarationMessage, ParameterMessage, QuantityMessage
from tsd_casadi.wire.error import ErrorMessage
from tsd_casadi.wire.feedforward import BandMessage, BoundMessage, FeedforwardMessage
from tsd_casadi.wire.health import AnswersMessage, DatabaseStateMessage, HealthMessage
from tsd_casadi.wire.info import FieldMessage, InfoMessage
from tsd_casadi.wire.latency import LatencyMessage
from tsd_casadi.wire.learner import (
    DamagedMessage,
    DatabaseReply,
    EntryMessage,
    IterationMessage,
    RecordReply,
)
from tsd_casadi.wire.message import Message
from tsd_casadi.wire.question import Question, question_texts
from tsd_casadi.wire.record import LapMessage, RecordMessage
from tsd_casadi.wire.run_record import RunRecord
from tsd_casadi.wire.suggestion import SuggestionMessage

CONTEXT = Context("00ff", "abcd", "c0ffee")
MADE = Circumstances({"P": [50.0], "D": [14.0]}, {"seed": 3, "hardware": {"delay": 0.1}}, "0.1.0")
KEY = EntryKey.of(
    "hermes_lower", "squat", "1", ("com.z",), {"amplitude": 0.03, "frequency": 0.25}, CONTEXT
)
DECLARATION = Squat.declaration()
PHASE = np.pi + np.linspace(0, 2 * np.pi, 20, endpoint=False)
# JSON: anything that json.loads gives back
PLAIN = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(max_size=5),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3)
    ),
    max_leaves=5,
)


def a_feedforward(seed: int = 0, L: int = 25) -> Feedforward:
    rng = np.random.default_rng(seed)
    return Feedforward(
        ("com.z", "torso.rz"),
        PeriodicBasis.of_size(L),
        rng.normal(size=(2, L)),
        rng.uniform(size=(2, L)),
        "generalised",
        {"amplitude": 0.05, "frequency": 0.25},
        {
            "entries": [1, 2],
            "iteration": 3,
            "errors": [None, {"com.z": {"rms": 1e-3}}],
            "context": {"body": "00ff", "formulation": "abcd", "correction": ""},
            "others": 4,
        },
        DECLARATION,
    )


def a_recording(seed: int = 0) -> Recording:
    rng = np.random.default_rng(seed)
    basis = PeriodicBasis.of_size(5)
    return Recording(
        key=KEY,
        basis=basis,
        applied=rng.normal(size=(1, 5)),
        laps=[
            Lap(PHASE + rng.normal(), rng.normal(size=(1, 20))),
            Lap(PHASE + rng.normal(), *rng.normal(size=(3, 1, 20))),
        ],
        errors={"com.z": AxisError(1e-3, ac_rms=1e-4)},
        circumstances=MADE,
        declaration=DECLARATION,
    )


INSTRUCTION = Instruction(find_rule("plain"), update=False, restart=True)


def an_entry() -> Entry:
    entry = Entry(KEY, PeriodicBasis.of_size(5), MADE, identifier=4, updated="2026-01-01")
    entry.add(a_recording())
    return entry


def an_info(controller: Controller) -> InfoMessage:
    return InfoMessage.of(
        controller.format,
        version="0.1.0",
        instance=2**63 + 5,
        protocol=1,
        model="abcd",
        body="00ff",
        formulation="ff00",
        ticks_served=7,
        ticks_refused=1,
    )


FEEDFORWARD = FeedforwardMessage.of("hermes_lower", "squat", a_feedforward())
RECORD = RecordMessage.of(a_recording(), INSTRUCTION)
ENTRY = EntryMessage.of(an_entry())
PLACE = Suggestion(
    {"amplitude": 0.05, "frequency": 0.4, "height": -0.02}, 0.03, {"others": 2}, DECLARATION
)
SUGGESTION = SuggestionMessage.of("hermes_lower", "squat", PLACE)
LATENCY = LatencyMessage(bounds=(25, 50), counts=(3, 0, 1))
ANSWERS = AnswersMessage(
    answered=4, refused={"malformed": 1}, failed={"KeyError": 2}, waiting=1, latency=LATENCY
)
DATABASE_STATE = DatabaseStateMessage(
    path="/tmp/d.sqlite",
    schema_version=4,
    entries=2,
    damaged=1,
    size=8192,
    last_write="2026-01-02T03:04:05+00:00",
)
SAMPLES: list[Document] = [
    ErrorMessage.of(EntryNotFound('nothing ä "quoted"')),
    QuantityMessage(value=0.05, unit="m"),
    BasisMessage.of(PeriodicBasis()),
    FEEDFORWARD,
    FEEDFORWARD.model_copy(
        update={
            "bands": [BandMessage(kind="simultaneous", coverage=0.9, half_width=[[0.1] * 25] * 2)],
            "bound": BoundMessage(largest=[1.0, 2.0], reason="1.5 times what was recorded"),
        }
    ),
    RECORD,
    RECORD.model_copy(update={"declaration": None}),
    RECORD.laps[0],
    RECORD.axes[0],
    RECORD.errors["com.z"],
    RECORD.context,
    RECORD.circumstances,
    DeclarationMessage.of(DECLARATION),
    ParameterMessage(name="pause", unit="s"),
    ENTRY,
    ENTRY.iterations[0],
    RecordReply(entry=ENTRY, notes=["worse"]),
    DatabaseReply(database="/tmp/d.sqlite", entries=[ENTRY]),
    DatabaseReply(database="/tmp/d.sqlite", entries=[ENTRY], forgotten=ENTRY),
    DatabaseReply(
        database="/tmp/d.sqlite", entries=[], damaged=(DamagedMessage(entry=3, reason="cut"),)
    ),
    SUGGESTION,
    SuggestionMessage.of("hermes_lower", "squat", replace(PLACE, standard_deviation=None)),
    CenterOfMassMessage(
        robot="hermes_lower",
        fingerprint="0123456789abcdef",
        links=("B_TR",),
        terms=[[0.1, 0.0, -0.2]],
        covariance=np.diag([1e-6, 2e-6, 3e-6]).tolist(),
    ),
    LATENCY,
    ANSWERS,
    DATABASE_STATE,
    RunRecord(
        role="controller",
        subject="hermes_lower",
        robot="hermes_lower",
        pid=1234,
        endpoints=("tcp/127.0.0.1:7447",),
        instance=0xC0FFEE,
        started="2026-01-02T03:04:05+00:00",
    ),
    HealthMessage(
        role="learner",
        robot="*",
        instance=0xC0FFEE,
        pid=1234,
        started="2026-01-02T03:04:05+00:00",
        uptime=61.5,
        versions={"zenoh": "1.10"},
        answers={"record": ANSWERS},
        ticks={"OK": 7},
        database=DATABASE_STATE,
    ),
]
CLASSES = [
    ErrorMessage,
    FieldMessage,
    InfoMessage,
    QuantityMessage,
    BasisMessage,
    FeedforwardMessage,
    BandMessage,
    BoundMessage,
    AxisMessage,
    AxisErrorMessage,
    DeclarationMessage,
    ParameterMessage,
    LapMessage,
    ContextMessage,
    CircumstancesMessage,
    RecordMessage,
    EntryMessage,
    IterationMessage,
    DamagedMessage,
    RecordReply,
    DatabaseReply,
    SuggestionMessage,
    CenterOfMassMessage,
    LatencyMessage,
    AnswersMessage,
    DatabaseStateMessage,
    HealthMessage,
    RunRecord,
]


def changed(message: Document, path: str, value: Any) -> bytes:
    """The message's JSON with one value replaced; the path is dotted."""
    document = json.loads(message.encode())
    *parents, last = path.split(".")
    place = document
    for step in parents:
        place = place[int(step)] if isinstance(place, list) else place[step]
    place[int(last) if isinstance(place, list) else last] = value
    return json.dumps(document).encode()


# round trips


def test_what_iterations_leave_comes_back_as_it_was() -> None:
    made, entry = a_recording(), an_entry()
    wave = np.sin(PHASE)[None, :]
    laps = [Lap(PHASE, wave, wave / 100, wave / 20)]
    entry.add(replace(made, laps=laps), Instruction(find_rule("stable")))
    message = EntryMessage.of(entry)
    assert len(message.contractions) == 1
    assert None in message.contractions[0].observed
    assert EntryMessage.decode(message.encode()).contractions == entry.contractions
    assert ENTRY.contractions == ()


def test_every_message_class_is_tested_here() -> None:
    # rows of a database and what a run publishes are documents as well, and tested there
    kinds = {*Document.__subclasses__(), *Message.__subclasses__()} - {Message}
    elsewhere = re.compile(r"\.(database|telemetry|run_outline)\b")
    messages = {kind for kind in kinds if not elsewhere.search(kind.__module__)}
    assert messages == set(CLASSES)


@pytest.mark.parametrize("message", SAMPLES, ids=lambda message: type(message).__name__)
def test_every_message_comes_back_as_it_was(message: Document) -> None:
    payload = message.encode()
    assert type(message).decode(payload) == message
    assert type(message).decode(payload).encode() == payload
    json.loads(payload.decode("utf-8"))


def test_info_comes_back_with_the_same_layouts(controller: Controller) -> None:
    info = InfoMessage.decode(an_info(controller).encode())
    assert info == an_info(controller)
    found = info.tick_format()
    assert found == controller.format
    assert f"{found.layout_hash:016x}" == info.layout_hash
    np.testing.assert_array_equal(found.request.defaults(), controller.format.request.defaults())
    np.testing.assert_array_equal(found.request.lower(), controller.format.request.lower())
    assert info.instance == 2**63 + 5


def test_info_says_where_each_field_lies(controller: Controller) -> None:
    document = json.loads(an_info(controller).encode())
    assert document["format"] == "tsd.info/2"
    for which in ("request", "reply"):
        end = 0
        for field in document[which]:
            assert field["offset"] == end
            end += field["size"]
            assert field["unit"]
        assert end == getattr(controller.format, which).size
    assert document["statuses"]["0"] == "solved"
    assert set(document["statuses"]) == {"0", "1", "2", "3", "4"}


@settings(max_examples=settings.default.max_examples // 3)
@given(seed=st.integers(0, 1000), size=st.integers(1, 30))
def test_feedforward_is_exact_over_json(seed: int, size: int) -> None:
    feedforward = a_feedforward(seed, size)
    payload = FeedforwardMessage.of("r", "squat", feedforward).encode()
    found = FeedforwardMessage.decode(payload).feedforward()
    assert found.declaration == DECLARATION
    np.testing.assert_array_equal(found.weights, feedforward.weights)
    np.testing.assert_array_equal(found.standard_deviations, feedforward.standard_deviations)
    told = {**feedforward.provenance, "robot": "r"}
    assert replace(found, weights=0, standard_deviations=0) == replace(  # type: ignore[arg-type]
        feedforward,
        weights=0,
        standard_deviations=0,  # type: ignore[arg-type]
        provenance=told,
    )


@settings(max_examples=settings.default.max_examples // 3)
@given(seed=st.integers(0, 1000))
def test_a_recording_is_exact_over_json(seed: int) -> None:
    recording = a_recording(seed)
    message = RecordMessage.decode(RecordMessage.of(recording, INSTRUCTION).encode())
    assert message.instruction() == INSTRUCTION
    found = message.recording("hermes_lower")
    np.testing.assert_array_equal(found.applied, recording.applied)
    for one, other in zip(found.laps, recording.laps, strict=True):
        np.testing.assert_array_equal(one.phase, other.phase)
        np.testing.assert_array_equal(one.feedback, other.feedback)
        assert (one.error is None) == (other.error is None)
        if other.error is not None:
            np.testing.assert_array_equal(one.error, other.error)
            np.testing.assert_array_equal(one.reference, other.reference)
    assert found.key == KEY
    for name in ("basis", "errors", "circumstances", "declaration"):
        assert getattr(found, name) == getattr(recording, name)


def test_rule_update_and_restart_have_careful_defaults() -> None:
    document = json.loads(RECORD.encode())
    for name in ("rule", "update", "restart"):
        del document[name]
    found = RecordMessage.decode(json.dumps(document).encode())
    assert found.instruction() == Instruction(find_rule("guarded"), update=True, restart=False)
    assert RecordMessage.of(a_recording()).instruction() == found.instruction()


def test_entry_message_says_what_is_served_and_tested() -> None:
    assert ENTRY.entry == 4
    assert ENTRY.parameters["amplitude"] == QuantityMessage(value=0.03, unit="m")
    assert [item.number for item in ENTRY.iterations] == [0, 1, 2]
    assert ENTRY.served == 2
    assert ENTRY.iterations[2].errors is None
    errors = ENTRY.iterations[1].errors
    assert errors is not None
    assert errors["com.z"].model_dump(exclude={"scatter"}, exclude_none=True) == {
        "rms": 1e-3,
        "ac_rms": 1e-4,
        "laps": 2,
        "unit": "m",
    }
    assert errors["com.z"].scatter is not None
    assert ENTRY.context.context() == CONTEXT
    assert ENTRY.axes == [AxisMessage(name="com.z", unit="m")]


def test_error_message_carries_code_and_data() -> None:
    message = ErrorMessage.of(InvalidValue("amplitude", 5, "less"))
    assert json.loads(message.encode()) == {
        "format": "tsd.error/2",
        "code": "invalid_value",
        "message": "amplitude is 5, expected less",
        "data": {"field": "amplitude", "value": 5, "expected": "less"},
    }


@pytest.mark.parametrize(
    "error",
    [
        InvalidValue("P[2]", -1.0, "a positive number"),
        OutsideTrainedRange("amplitude", 0.2, 0.02, 0.08, "m"),
        UnknownField("ampl", ["amplitude", "frequency"]),
        DatabaseError(Path("/tmp/d.sqlite"), "cannot be read", "restore a copy"),
        EntryNotFound("nothing yet"),
    ],
    ids=lambda error: type(error).__name__,
)
def test_an_error_arrives_with_its_data(error: TsdError) -> None:
    found = ErrorMessage.decode(ErrorMessage.of(error).encode()).error()
    assert type(found) is type(error)
    assert str(found) == str(error)
    assert vars(found) == vars(error)


@pytest.mark.parametrize(
    "data",
    [{"low": "x"}, {"low": [1]}, {"__class__": 1}, {"code": "internal"}, {"args": []}, {"with": 1}],
)
def test_data_that_makes_no_sense_is_dropped(data: dict[str, Any]) -> None:
    message = ErrorMessage(code="extrapolation", message="no", data=data)
    found = ErrorMessage.decode(message.encode()).error()
    assert isinstance(found, OutsideTrainedRange)
    assert (str(found), found.low, found.code, vars(found)) == ("no", None, "extrapolation", {})


def test_data_is_plain_and_bounded() -> None:
    message = ErrorMessage.of(InvalidValue("x" * 10**5, {"a": object()}, "b"))
    data = json.loads(message.encode())["data"]
    assert (len(data["field"]), type(data["value"])) == (1000, str)
    assert json.loads(ErrorMessage.of(InvalidValue("x", math.nan, "b")).encode())["data"] == {
        "field": "x",
        "value": None,
        "expected": "b",
    }


def test_an_unknown_code_is_a_service_that_failed() -> None:
    found = ErrorMessage(code="dreamt", message="no", data={"low": 1}).error()
    assert isinstance(found, ServiceFailed)
    assert (found.code, str(found)) == ("dreamt", "no")


# version 1

VERSION_1: dict[type[Document], dict[str, Any]] = {
    RecordMessage: {"task": "squat", "axes": ["com.z"], "parameters": {}, "laps": []},
    FeedforwardMessage: {"format": "tsd.feedforward/1", "robot": "r", "task": "squat"},
    SuggestionMessage: {"format": "tsd.suggestion/1", "robot": "r", "task": "squat"},
    RecordReply: {"entry": {"entry": 1, "task": "squat"}, "notes": []},
    DatabaseReply: {"database": "/tmp/d.sqlite", "entries": []},
    InfoMessage: {"format": "tsd.info/1", "robot": "r"},
}


@pytest.mark.parametrize("kind", VERSION_1, ids=lambda kind: kind.__name__)
def test_a_message_of_version_1_is_told_what_to_send(kind: type[Document]) -> None:
    # health and what runs publish came with version 2
    since = {kind for kind in Message.__subclasses__() if kind.__module__.endswith(".telemetry")}
    assert {*VERSION_1, HealthMessage} == set(Message.__subclasses__()) - since
    with pytest.raises(UnsupportedVersion, match=r"/2.*'motion' in place of 'task'"):
        kind.decode(json.dumps(VERSION_1[kind]).encode())


def test_who_speaks_version_1_can_read_that_error() -> None:
    message = ErrorMessage.of(UnsupportedVersion("a query of version 1", "another"))
    assert json.loads(message.encode()).keys() == {"code", "message"}


# queries

EXAMPLE = "?motion=squat;amplitude=0.05"


def test_a_question_comes_back_as_it_was() -> None:
    texts = question_texts(
        "squat", {"amplitude": 0.1 + 0.2}, version="1+ab", axes=("com.z", "com.x"), context=CONTEXT
    )
    found = Question.of({**texts, "kind": "learned", "extrapolate": "True"}, EXAMPLE)
    assert (found.motion, found.version, found.axes) == ("squat", "1+ab", ("com.z", "com.x"))
    assert (found.context, found.kind, found.extrapolate) == (CONTEXT, "learned", True)
    assert found.numbers() == {"amplitude": 0.1 + 0.2}
    short = question_texts("squat", {}, version=None, axes=None, context=None)
    assert short == {"motion": "squat"}
    found = Question.of(short, EXAMPLE)
    assert (found.version, found.axes, found.context, found.kind) == (None, None, None, None)
    nowhere = question_texts("squat", {}, version=None, axes=None, context=Context())
    assert Question.of(nowhere, EXAMPLE).context == Context()


@pytest.mark.parametrize(
    ("texts", "error", "named"),
    [
        ({}, MalformedMessage, "no motion"),
        ({"task": "squat"}, UnsupportedVersion, "'motion=' in place of it"),
        ({"motion": "squat", "task": "squat"}, UnsupportedVersion, "version 1"),
        ({"motion": "a b"}, InvalidValue, "motion is 'a b'"),
        ({"motion": "x" * 101}, InvalidValue, "motion"),
        ({"motion": "squat", "axes": ""}, InvalidValue, "axes is ''"),
        ({"motion": "squat", "axes": "com.z,com.z"}, InvalidValue, "each axis once"),
        ({"motion": "squat", "axes": "com/z"}, InvalidValue, "com/z"),
        ({"motion": "squat", "body": "00ff"}, InvalidValue, "body and formulation"),
        ({"motion": "squat", "correction": "00ff"}, InvalidValue, "body and formulation"),
        ({"motion": "squat", "body": "a b", "formulation": "x"}, InvalidValue, "body is 'a b'"),
        ({"motion": "squat", "body": "x", "formulation": "x" * 201}, InvalidValue, "formulation"),
        ({"motion": "squat", "version": "1 2"}, InvalidValue, "version is '1 2'"),
        ({"motion": "squat", "kind": "best"}, InvalidValue, "learned or generalised"),
        ({"motion": "squat", "extrapolate": "2"}, InvalidValue, "true or false"),
        ({"motion": "squat", "robot": "1"}, InvalidValue, "'robot'"),
        ({"motion": "squat", "amplitude": "x"}, InvalidValue, "amplitude is 'x'"),
        ({"motion": "squat", "a b": "1"}, InvalidValue, "'a b'"),
        (
            {"motion": "squat", **{f"p{n}": "1" for n in range(60)}},
            MalformedMessage,
            "61 fields",
        ),
    ],
)
def test_questions_that_make_no_sense_are_refused(
    texts: dict[str, str], error: type[TsdError], named: str
) -> None:
    with pytest.raises(error, match=named):
        Question.of(texts, EXAMPLE).numbers()


# what a client without this software has to work with


@settings(max_examples=settings.default.max_examples // 3)
@given(seed=st.integers(0, 1000), phase=st.floats(-50, 50))
def test_samples_rebuilt_from_the_json_alone_are_the_feedforward(seed: int, phase: float) -> None:
    feedforward = a_feedforward(seed)
    document = json.loads(FeedforwardMessage.of("r", "squat", feedforward).encode())
    phases = phase + np.linspace(0, 2 * np.pi, 13)
    centres = np.array(document["basis"]["centres"])
    bumps = np.exp(document["basis"]["width"] * (np.cos(phases[:, None] - centres) - 1))
    psi = bumps / bumps.sum(axis=1, keepdims=True)
    samples = np.array(document["weights"]) @ psi.T
    np.testing.assert_allclose(samples, feedforward.mean(phases), rtol=0, atol=1e-12)
    deviations = np.array(document["standard_deviations"]) @ psi.T
    np.testing.assert_allclose(deviations, feedforward.std(phases), rtol=0, atol=1e-12)


def test_feedforward_json_has_format_units_and_names() -> None:
    document = json.loads(FEEDFORWARD.encode())
    assert document["format"] == "tsd.feedforward/2"
    assert (document["motion"], document["version"]) == ("squat", DECLARATION.version)
    assert document["context"] == {"body": "00ff", "formulation": "abcd", "correction": ""}
    assert document["others"] == 4
    declared = document["declaration"]["parameters"]
    assert [item["name"] for item in declared] == ["amplitude", "frequency", "height"]
    assert document["parameters"]["frequency"] == {"value": 0.25, "unit": "Hz"}
    assert document["axes"] == [
        {"name": "com.z", "unit": "m"},
        {"name": "torso.rz", "unit": "rad"},
    ]
    assert document["basis"]["kind"] == "periodic"
    assert document["basis"]["L"] == len(document["basis"]["centres"]) == 25


def test_json_schema_covers_every_field_of_the_feedforward() -> None:
    schema = json.loads(json_schema(FeedforwardMessage))
    document = json.loads(FEEDFORWARD.encode())
    assert schema["type"] == "object"
    assert schema["additionalProperties"] is False
    assert set(schema["properties"]) == set(document)
    assert schema["properties"]["format"]["const"] == "tsd.feedforward/2"
    later = {"instance", "version", "context", "others", "epoch", "declaration", "bands", "bound"}
    assert set(schema["required"]) == set(document) - {"format"} - later


# what is refused

MALFORMED: dict[str, tuple[Document, str, Any]] = {
    f"{type(message).__name__} {path} = {value!r}": (message, path, value)
    for message, path, values in [
        (FEEDFORWARD, "instance", [-1, None, "x"]),
        (FEEDFORWARD, "version", ["1 2", None, "x" * 101]),
        (FEEDFORWARD, "others", [-1, None, "x"]),
        (FEEDFORWARD, "epoch", [-1, None, 1.5]),
        (FEEDFORWARD, "context", [None, {"model": "x"}, {"body": "a b"}]),
        (FEEDFORWARD, "bands", [{}, [1], [{"kind": "wide"}]]),
        (FEEDFORWARD, "bound", [1.0, {"largest": [-1.0]}, {"largest": math.nan}]),
        (FEEDFORWARD, "axes.0.unit", ["cm", None, ""]),
        (FEEDFORWARD, "declaration.parameters.0.low", ["x", None]),
        (FEEDFORWARD, "declaration.parameters.0.unit", [None, "x" * 21]),
        (FEEDFORWARD, "declaration.motion", [None, "a b"]),
        (FEEDFORWARD, "kind", ["learnt", "", None, 3]),
        (FEEDFORWARD, "axes", ["com.z", None, [1], {}, [], ["com.z"]]),
        (FEEDFORWARD, "robot", [None, 1, []]),
        (FEEDFORWARD, "weights", [None, 1, [1.0], [["x"]], [[None]], [[[1.0]]], {}]),
        (FEEDFORWARD, "weights.0.3", [math.nan, math.inf, -math.inf, 1e10, None, "x", [1.0]]),
        (FEEDFORWARD, "standard_deviations.1.0", [math.nan, math.inf, None, "x"]),
        (FEEDFORWARD, "basis", [None, {}, []]),
        (FEEDFORWARD, "basis.kind", ["fourier", None]),
        (FEEDFORWARD, "basis.L", [0, -1, 1001, 2.5, None, "x"]),
        (FEEDFORWARD, "basis.width", [0, -1, 1e6, math.nan, math.inf, None]),
        (FEEDFORWARD, "basis.centres", [None, 1.0, ["x"]]),
        (FEEDFORWARD, "basis.centres.2", [math.nan, None]),
        (FEEDFORWARD, "parameters.amplitude", [0.05, None, {"value": 0.05}, {"unit": "m"}]),
        (FEEDFORWARD, "parameters.amplitude.value", [math.nan, math.inf, None, "x"]),
        (FEEDFORWARD, "provenance", [None, [], "x"]),
        (FEEDFORWARD, "more", [1]),
        (RECORD, "motion", ["", "1squat", "a b", "a/b", "a*", "x" * 101, None]),
        (RECORD, "axes", [[], ["com.z"], [{"name": "a"}] * 51, None, "com.z"]),
        (RECORD, "axes.0.name", ["", "com/z", None, 1]),
        (RECORD, "parameters", [None, [], {"a b": 1.0}, {"amplitude": math.nan}]),
        (RECORD, "parameters.amplitude", [math.nan, math.inf, None, "x", 1e10]),
        (RECORD, "applied.0.0", [math.nan, math.inf, None, "x", 1e10]),
        (RECORD, "laps", [[], None, {}]),
        (RECORD, "laps.0", [None, {}, []]),
        (RECORD, "laps.1.phase", [[0.0] * 9, [], None]),
        (RECORD, "laps.1.phase.4", [math.nan, math.inf, None]),
        (RECORD, "laps.0.feedback.0.7", [math.nan, -math.inf, None, 1e10]),
        (RECORD, "laps.1.error.0.7", [math.nan, -math.inf, None, 1e10]),
        (RECORD, "laps.1.reference", [1.0, [1.0], {}]),
        (RECORD, "version", [None, 1, "1 2", "x" * 101]),
        (RECORD, "errors", [None, [], {"com.z": math.nan}, {"com z": {"rms": 1.0, "unit": "m"}}]),
        (RECORD, "context", [None, [], {"model": "x"}]),
        (RECORD, "context.formulation", [None, 1, "x" * 201, "a b"]),
        (RECORD, "context.body", [None, 1, "x" * 201, "a/b"]),
        (RECORD, "context.correction", [None, 1, "x" * 201]),
        (RECORD, "circumstances", [None, {}, {"gains": {}, "more": 1}]),
        (RECORD, "circumstances.version", [None, 1, "x" * 101]),
        (
            RECORD,
            "circumstances.gains",
            [None, [], {"P": 1.0}, {"P": [math.nan]}, {"P": [1.0] * 51}],
        ),
        (RECORD, "circumstances.setting", [None, [], 1]),
        (RECORD, "declaration", [1, {}, {"motion": "squat"}]),
        (RECORD, "declaration.parameters", [None, [1], [{"name": "a", "unit": "m"}] * 51]),
        (RECORD, "declaration.parameters.0.name", ["", "a b", None]),
        (RECORD, "rule", ["reckless", None, ""]),
        (RECORD, "update", ["perhaps", None, 3]),
        (RECORD, "restart", ["perhaps", None, 3]),
        (RECORD, "more", [1]),
        (ENTRY, "iterations.0", [None, [1], {}, {"number": "x"}, {"number": 1, "errors": 1}]),
        (ENTRY, "rule", ["reckless"]),
        (SUGGESTION, "parameters.height", [None, 0.0, {"value": math.nan, "unit": "m"}]),
        (SUGGESTION, "standard_deviation", [math.nan, -1.0, "x"]),
        (SUGGESTION, "others", [-1, None]),
    ]
    for value in values
}


@pytest.mark.parametrize("case", MALFORMED)
def test_a_malformed_field_is_refused_by_name(case: str) -> None:
    message, path, value = MALFORMED[case]
    kind = type(message)
    with pytest.raises(MalformedMessage) as caught:
        kind.decode(changed(message, path, value))
    text = str(caught.value)
    assert text.startswith(f"{kind.__name__}: ")
    assert path.split(".")[0] in text


@pytest.mark.parametrize("message", SAMPLES, ids=lambda message: type(message).__name__)
def test_a_missing_field_is_refused_by_name(message: Document) -> None:
    kind = type(message)
    document = json.loads(message.encode())
    for name, field in kind.model_fields.items():
        if not field.is_required():
            continue
        payload = json.dumps({k: v for k, v in document.items() if k != name}).encode()
        with pytest.raises(MalformedMessage, match=name):
            kind.decode(payload)


@pytest.mark.parametrize("message", SAMPLES, ids=lambda message: type(message).__name__)
def test_an_unknown_field_is_refused(message: Document) -> None:
    with pytest.raises(MalformedMessage, match="surprise"):
        type(message).decode(changed(message, "surprise", 1))


SHAPES: dict[str, tuple[Document, str, Any]] = {
    "a row of weights too many": (FEEDFORWARD, "weights", [[0.0] * 25] * 3),
    "a row of weights too few": (FEEDFORWARD, "weights", [[0.0] * 25]),
    "no weights": (FEEDFORWARD, "weights", []),
    "a weight too few": (FEEDFORWARD, "weights.1", [0.0] * 24),
    "a weight too many": (FEEDFORWARD, "weights.0", [0.0] * 26),
    "a deviation too few": (FEEDFORWARD, "standard_deviations.1", [0.0] * 24),
    "another number of centres": (FEEDFORWARD, "basis.centres", [0.0]),
    "centres elsewhere": (FEEDFORWARD, "basis.centres.3", 1.0),
    "another L": (FEEDFORWARD, "basis.L", 24),
    "a lap's feedback too short": (RECORD, "laps.0.feedback.0", [0.0] * 19),
    "a lap's error too short": (RECORD, "laps.1.error.0", [0.0] * 19),
    "a lap's reference too wide": (RECORD, "laps.1.reference", [[0.0] * 20] * 2),
    "a lap's feedback too wide": (RECORD, "laps.0.feedback", [[0.0] * 20] * 2),
    "applied too short": (RECORD, "applied.0", [0.0] * 4),
    "applied too wide": (RECORD, "applied", [[0.0] * 5] * 2),
    "an axis too many": (
        RECORD,
        "axes",
        [{"name": "com.x", "unit": "m"}, {"name": "com.z", "unit": "m"}],
    ),
    "an axis twice": (FEEDFORWARD, "axes", [{"name": "com.z", "unit": "m"}] * 2),
    "an axis in another unit": (RECORD, "axes.0.unit", "rad"),
    "errors of no axis": (RECORD, "errors", {}),
    "errors of another axis": (RECORD, "errors", {"com.x": {"rms": 1.0, "unit": "m"}}),
    "errors in another unit": (RECORD, "errors", {"com.z": {"rms": 1.0, "unit": "rad"}}),
    "no RMS error": (RECORD, "errors", {"com.z": {"ac_rms": 1.0, "unit": "m"}}),
    "a negative RMS error": (RECORD, "errors", {"com.z": {"rms": -1.0, "unit": "m"}}),
    "an error that is not finite": (RECORD, "errors", {"com.z": {"rms": math.nan, "unit": "m"}}),
    "a setting without end": (RECORD, "circumstances.setting", {"x": "y" * 30_000}),
    "a range the wrong way round": (RECORD, "declaration.parameters.0.low", 2e6),
    "a parameter twice": (
        RECORD,
        "declaration.parameters",
        [{"name": "amplitude", "unit": "m"}] * 2,
    ),
}


@pytest.mark.parametrize("case", SHAPES)
def test_shapes_that_do_not_fit_are_refused(case: str) -> None:
    message, path, value = SHAPES[case]
    with pytest.raises(MalformedMessage):
        decoded = type(message).decode(changed(message, path, value))
        _unpack(decoded)


def _unpack(message: Document) -> None:
    if isinstance(message, FeedforwardMessage):
        message.feedforward().mean([0.0, 1.0])
    if isinstance(message, RecordMessage):
        message.recording("hermes_lower")


@pytest.mark.parametrize("kind", CLASSES)
@settings(max_examples=settings.default.max_examples // 2)
@given(payload=st.binary(max_size=60))
def test_arbitrary_bytes_are_refused_as_malformed(kind: type[Document], payload: bytes) -> None:
    with pytest.raises(MalformedMessage):
        kind.decode(payload)


@pytest.mark.parametrize("kind", CLASSES)
@settings(max_examples=settings.default.max_examples // 2)
@given(document=PLAIN)
def test_arbitrary_json_is_refused_as_malformed(kind: type[Document], document: Any) -> None:
    with pytest.raises(MalformedMessage):
        kind.decode(json.dumps(document).encode())


IN_FEEDFORWARD = """robot axes axes.0 parameters basis basis.L basis.centres basis.width weights
    weights.0 standard_deviations provenance provenance.x kind motion version context declaration
    declaration.parameters bands bound others instance"""
IN_RECORD = """motion version axes parameters parameters.x basis applied applied.0 laps laps.0
    laps.0.phase laps.0.feedback errors errors.x context context.body circumstances
    circumstances.gains circumstances.setting declaration declaration.parameters.0 rule update"""
WHERE: list[tuple[Document, str]] = [
    *((FEEDFORWARD, path) for path in IN_FEEDFORWARD.split()),
    *((RECORD, path) for path in IN_RECORD.split()),
]


@settings(max_examples=settings.default.max_examples * 3)
@given(
    where=st.sampled_from(WHERE),
    value=PLAIN | st.lists(st.lists(st.floats(), max_size=26), max_size=3),
)
def test_an_arbitrary_value_anywhere_raises_nothing_else(
    where: tuple[Document, str], value: Any
) -> None:
    message, path = where
    try:
        _unpack(type(message).decode(changed(message, path, value)))
    except MalformedMessage as error:
        assert str(error)


@settings(max_examples=settings.default.max_examples * 2)
@given(where=st.integers(0, 3000), byte=st.integers(0, 255), cut=st.integers(0, 4000))
def test_damaged_json_raises_nothing_else(where: int, byte: int, cut: int) -> None:
    payload = bytearray(RECORD.encode())
    payload[where % len(payload)] = byte
    try:
        _unpack(RecordMessage.decode(bytes(payload[: cut or None])))
    except MalformedMessage as error:
        assert str(error)


@pytest.mark.parametrize(
    "payload",
    [
        b"",
        b"null",
        b"[]",
        b"\xff\xfe",
        b"[" * 100_000,
        b'{"a":' * 10_000,
        b"9" * 10_000,
        b'{"provenance": ' + b"9" * 10_000 + b"}",
        b'{"motion": "\\ud800"}',
        '{"motion": "squat"}'.encode("utf-16"),
        b'\xef\xbb\xbf{"motion": "squat"}',
        b'{"motion": NaN}',
        b'{"motion": "squat"',
    ],
)
@pytest.mark.parametrize("kind", CLASSES)
def test_hostile_payloads_are_refused_as_malformed(kind: type[Document], payload: bytes) -> None:
    with pytest.raises(MalformedMessage):
        kind.decode(payload)


def test_centres_that_are_off_by_more_than_1e_9_are_refused() -> None:
    message = FeedforwardMessage.decode(
        changed(FEEDFORWARD, "basis.centres.24", 2 * math.pi * 24 / 25 + 5e-5)
    )
    with pytest.raises(MalformedMessage):
        message.feedforward()


def test_bands_are_exact_over_json() -> None:
    feedforward = a_feedforward()
    bands = tuple(
        Band(kind, 0.95, factor * feedforward.standard_deviations)
        for kind, factor in (("pointwise", 2.0), ("simultaneous", 3.5))
    )
    message = FeedforwardMessage.of("r", "squat", replace(feedforward, bands=bands))
    found = FeedforwardMessage.decode(message.encode()).feedforward().bands
    assert [(band.kind, band.coverage) for band in found] == [
        ("pointwise", 0.95),
        ("simultaneous", 0.95),
    ]
    for band, expected in zip(found, bands, strict=True):
        np.testing.assert_array_equal(band.half_width, expected.half_width)
    document = json.loads(message.encode())
    document["bands"][1]["half_width"].pop()
    with pytest.raises(MalformedMessage, match="half_width of another shape"):
        FeedforwardMessage.decode(json.dumps(document).encode()).feedforward()


def test_a_feedforward_of_no_axes_is_refused() -> None:
    document = json.loads(FEEDFORWARD.encode())
    document.update(axes=[], weights=[], standard_deviations=[])
    with pytest.raises(MalformedMessage):
        _unpack(FeedforwardMessage.decode(json.dumps(document).encode()))


@pytest.mark.parametrize(
    ("message", "path"),
    [
        (FEEDFORWARD, "provenance.x"),
        (ENTRY, "learning_gain"),
        (ENTRY, "iterations.0"),
    ],
)
def test_nan_is_refused_everywhere(message: Document, path: str) -> None:
    broken = {"number": 0, "errors": {"com.z": {"rms": math.nan, "unit": "m"}}}
    value: Any = broken if path == "iterations.0" else math.nan
    with pytest.raises(MalformedMessage):
        type(message).decode(changed(message, path, value))


def test_a_suggestion_comes_back_as_it_was() -> None:
    assert SuggestionMessage.decode(SUGGESTION.encode()).suggestion() == PLACE
    document = json.loads(SUGGESTION.encode())
    assert document["parameters"]["height"] == {"value": -0.02, "unit": "m"}
    assert document["others"] == 2
    assert SuggestionMessage.decode(SUGGESTION.encode()).version == DECLARATION.version


def test_a_parameter_in_another_unit_is_refused() -> None:
    message = FeedforwardMessage.decode(changed(FEEDFORWARD, "parameters.amplitude.unit", "cm"))
    with pytest.raises(MalformedMessage, match=r"amplitude of a squat in 'cm'"):
        message.feedforward()
    place = SuggestionMessage.decode(changed(SUGGESTION, "parameters.frequency.unit", "rad/s"))
    with pytest.raises(MalformedMessage, match=r"frequency of a squat in 'rad/s'"):
        place.suggestion()


def test_parameters_of_a_motion_of_somebodys_own_have_no_unit() -> None:
    feedforward = replace(a_feedforward(), parameters={"depth": 1.0}, declaration=None)
    message = FeedforwardMessage.of("r", "bow", feedforward)
    assert message.parameters["depth"] == QuantityMessage(value=1.0, unit="")
    assert FeedforwardMessage.decode(message.encode()).feedforward().parameters == {"depth": 1.0}


def test_negative_standard_deviations_are_refused() -> None:
    with pytest.raises(MalformedMessage):
        _unpack(FeedforwardMessage.decode(changed(FEEDFORWARD, "standard_deviations.0.0", -1.0)))


@pytest.mark.parametrize(("name", "value"), [("size", 3), ("offset", 99), ("size", -1)])
def test_an_info_whose_layout_contradicts_itself_is_refused(
    controller: Controller, name: str, value: int
) -> None:
    with pytest.raises(MalformedMessage):
        InfoMessage.decode(changed(an_info(controller), f"request.1.{name}", value)).tick_format()


@pytest.mark.parametrize(
    "provenance",
    [{}, {"entries": [1]}, {"iteration": 1}, {"entries": 1, "iteration": 1}]
    + [{"entries": [1], "iteration": wrong} for wrong in (None, "x", 1.5, [1], True)],
)
def test_a_feedforward_without_its_origin_is_refused(provenance: dict[str, Any]) -> None:
    message = FEEDFORWARD.model_copy(update={"provenance": provenance})
    with pytest.raises(MalformedMessage, match="a list of entries"):
        FeedforwardMessage.decode(message.encode()).feedforward()
