from __future__ import annotations

import inspect
import os
import pickle
import re
from pathlib import Path
from typing import Any

import pytest

from tsd_casadi import exceptions
from tsd_casadi.exceptions import TsdError
from tsd_casadi.exceptions.discrepancy import Discrepancy
from tsd_casadi.wire.error import ErrorMessage

HERE = Path("/some/where/robot.yaml")
KNEE = Discrepancy("joint knee", "armature", "0.1 kg m^2", "0 kg m^2", "delete it")
# every class: its arguments, the attributes it carries, words its message needs
CASES: dict[str, tuple[tuple[Any, ...], dict[str, Any], list[str]]] = {
    "TsdError": (("what",), {}, ["what"]),
    "RobotFileError": (
        (HERE, "tasks.0.P", "is -1", "a positive number"),
        {"path": HERE, "field": "tasks.0.P", "expected": "a positive number"},
        [str(HERE), "field 'tasks.0.P'", "is -1", "expected a positive number"],
    ),
    "UnknownRobot": (
        ("hermse", ["hermes_lower", "other"]),
        {"name": "hermse", "known": ["hermes_lower", "other"]},
        ["'hermse'", "hermes_lower, other", ".yaml"],
    ),
    "UnknownField": (
        ("com.Q", ["com.P", "com.D"]),
        {"name": "com.Q", "known": ["com.P", "com.D"]},
        ["'com.Q'", "com.P, com.D"],
    ),
    "InvalidValue": (
        ("amplitude", 5, "0.001 to 0.08 m"),
        {"field": "amplitude", "value": 5, "expected": "0.001 to 0.08 m"},
        ["amplitude is 5", "expected 0.001 to 0.08 m"],
    ),
    "MalformedMessage": (("12 bytes", "32"), {"expected": "32"}, ["12 bytes", "expected 32"]),
    "UnsupportedVersion": (("version 2", "1"), {"expected": "1"}, ["version 2"]),
    "LayoutMismatch": (("layout 1", "layout 2"), {"expected": "layout 2"}, ["layout 1"]),
    "CompilerNotFound": (
        (["cc", "gcc"],),
        {"tried": ["cc", "gcc"]},
        ["cc, gcc", "apt install gcc", "CC"],
    ),
    "CompilationFailed": (
        (["gcc", "-O2", "a.c"], "first\nsecond\nlast"),
        {"command": ["gcc", "-O2", "a.c"], "output": "first\nsecond\nlast"},
        ["gcc -O2 a.c", "last"],
    ),
    "ControllerSilent": (
        (30.0, "late"),
        {"patience": 30.0, "why": "late"},
        ["30 s (late)", "fallback", "--patience"],
    ),
    "CacheNotPrivate": ((HERE,), {"path": HERE}, [str(HERE), "chmod 700", "TSD_CACHE_DIR"]),
    "CacheNotWritable": (
        (HERE, "No space left on device"),
        {"path": HERE, "reason": "No space left on device"},
        [str(HERE), "No space left on device", "make room", "TSD_CACHE_DIR"],
    ),
    "NotLoadable": (
        (HERE, "file too short"),
        {"path": HERE, "reason": "file too short"},
        [str(HERE), "file too short", "delete it", "TSD_CACHE_DIR"],
    ),
    "ParityError": (
        ("hermes_lower", HERE, [KNEE, KNEE]),
        {"path": HERE, "discrepancies": [KNEE, KNEE]},
        [str(HERE), "'hermes_lower' in 2 ways", "joint knee: armature is 0.1", "delete it"],
    ),
    "DatabaseError": (
        (HERE, "is locked", "wait"),
        {"path": HERE},
        [str(HERE), "is locked", "wait"],
    ),
    "LogNotWritten": (
        (HERE, "no space left"),
        {"path": HERE, "reason": "no space left"},
        [str(HERE), "no space left", "tsd log recover"],
    ),
    "LogNotWhole": ((HERE, "no footer"), {"path": HERE}, [str(HERE), "no footer", "log recover"]),
    "EntryNotFound": (("nothing",), {}, ["nothing"]),
    "OutsideTrainedRange": (
        ("amplitude", 0.1, 0.02, 0.08, "m"),
        {"parameter": "amplitude", "value": 0.1, "low": 0.02, "high": 0.08},
        ["amplitude 0.1 m", "0.02 to 0.08 m", "extrapolate=true"],
    ),
    "IncompatibleEntry": (("other basis",), {}, ["other basis"]),
    "ServiceUnreachable": (
        ("controller", ["tcp/127.0.0.1:7447"], "timeout"),
        {"role": "controller", "endpoints": ["tcp/127.0.0.1:7447"]},
        ["no controller", "tcp/127.0.0.1:7447", "timeout", "tsd controller", "--connect"],
    ),
    "ServiceBusy": (
        ("learner", ["tcp/127.0.0.1:7448"], 30.0),
        {"role": "learner", "endpoints": ["tcp/127.0.0.1:7448"], "timeout": 30.0},
        ["the learner at tcp/127.0.0.1:7448", "within 30 s", "at work", "tsd database list"],
    ),
    "ServiceFailed": (("internal", "it broke"), {"code": "internal"}, ["it broke"]),
    "ServiceNotReady": (("not ready after 1 s",), {}, ["not ready after 1 s"]),
    "AlreadyRunning": (
        ("controller", "hermes_lower", 12, "tcp/127.0.0.1:7447", "2030-01-01T00:00:00+00:00"),
        {
            "role": "controller",
            "subject": "hermes_lower",
            "pid": 12,
            "endpoint": "tcp/127.0.0.1:7447",
            "since": "2030-01-01T00:00:00+00:00",
        },
        ["controller for hermes_lower", "process 12", "7447", "since 2030", "kill 12", "status"],
    ),
    "RunDirectoryUnusable": (
        (HERE, "others can enter it"),
        {"path": HERE, "reason": "others can enter it"},
        [str(HERE), "others can enter it", "chmod 700", "TSD_RUN_DIR"],
    ),
    "CertificateRefused": (
        ("tls/robot:7447", "its certificate has expired", "make a new one"),
        {"endpoint": "tls/robot:7447", "reason": "its certificate has expired"},
        ["tls/robot:7447", "has expired", "make a new one"],
    ),
    "EndpointTaken": (
        ("learner", "tcp/127.0.0.1:7448", "in use"),
        {"endpoint": "tcp/127.0.0.1:7448"},
        ["learner", "tcp/127.0.0.1:7448", "in use", "--listen"],
    ),
    "TwoServices": (("two",), {}, ["two"]),
    "NotAvailable": (
        ("a film", "the extra 'view'", "pip install"),
        {"what": "a film", "missing": "the extra 'view'", "remedy": "pip install"},
        ["a film needs the extra 'view'", "pip install"],
    ),
    "SimulationError": (("fell",), {}, ["fell"]),
}


FAMILIES = ("RobotError", "ControllerError", "LearningError", "LogError", "ServiceError")


def every_class() -> dict[str, type[TsdError]]:
    return {
        name: value
        for name, value in vars(exceptions).items()
        if inspect.isclass(value) and issubclass(value, Exception)
    }


def subclasses(parent: type[TsdError]) -> set[type[TsdError]]:
    return {parent}.union(*map(subclasses, parent.__subclasses__()))


def test_every_class_is_tested_here() -> None:
    assert every_class().keys() == CASES.keys() | set(FAMILIES)


def test_every_class_can_be_imported_from_the_package() -> None:
    ours = {kind for kind in subclasses(TsdError) if kind.__module__.startswith("tsd_")}
    assert ours == set(every_class().values())
    assert set(exceptions.__all__) == {*every_class(), "class_of"}


def test_the_tree_of_the_docstring_is_that_of_the_classes() -> None:
    tree = re.findall(r"^    ([│├└─ ]*)(\w+)", exceptions.__doc__ or "", re.MULTILINE)
    parents: dict[str, str] = {}
    above: list[str] = []
    for branch, name in tree:
        depth = len(branch) // 4
        above[depth:] = [name]
        parents[name] = above[depth - 1] if depth else "Exception"
    assert parents == {name: kind.__bases__[0].__name__ for name, kind in every_class().items()}


def test_a_family_is_nothing_that_is_raised_itself() -> None:
    for name in FAMILIES:
        kind = every_class()[name]
        assert kind.__bases__ == (TsdError,)
        assert "code" not in vars(kind)
        assert subclasses(kind) != {kind}


@pytest.mark.parametrize("name", CASES)
def test_all_can_be_caught_as_one(name: str) -> None:
    assert issubclass(every_class()[name], TsdError)


@pytest.mark.parametrize("name", CASES)
def test_data_are_attributes_and_the_message_says_it_all(name: str) -> None:
    arguments, attributes, words = CASES[name]
    error = every_class()[name](*arguments)
    for attribute, value in attributes.items():
        assert getattr(error, attribute) == value
    for word in words:
        assert word in str(error)


def test_codes_are_distinct_words() -> None:
    # a ServiceFailed repeats the code of the service
    kinds = [kind for name, kind in every_class().items() if name != "ServiceFailed"]
    codes = [kind.code for kind in kinds if kind.__name__ not in FAMILIES]
    assert len(set(codes)) == len(codes)
    assert all(code.isidentifier() and code.islower() for code in codes)


@pytest.mark.parametrize("name", CASES)
def test_an_error_arrives_as_what_it_was(name: str) -> None:
    arguments, attributes, _ = CASES[name]
    sent = every_class()[name](*arguments)
    arrived = ErrorMessage.decode(ErrorMessage.of(sent).encode()).error()
    assert type(arrived) is type(sent)
    assert (str(arrived), arrived.code) == (str(sent), sent.code)
    # whoever speaks version 1 has to be able to read that it does
    told = {} if isinstance(sent, exceptions.UnsupportedVersion) else attributes
    for attribute in attributes.keys() - {"code"}:
        assert getattr(arrived, attribute) == told.get(attribute)
    again = pickle.loads(pickle.dumps(arrived))
    assert (type(again), str(again), again.code) == (type(sent), str(sent), sent.code)


@pytest.mark.parametrize("code", ["internal", "of_a_later_version", ""])
def test_an_unknown_code_is_kept(code: str) -> None:
    arrived = ErrorMessage(code=code, message="it broke").error()
    assert isinstance(arrived, exceptions.ServiceFailed)
    assert (str(arrived), arrived.code) == ("it broke", code)


def test_a_path_that_is_no_text_can_be_told() -> None:
    path = Path(os.fsdecode(b"/some/\xff.sqlite"))
    message = ErrorMessage.of(exceptions.DatabaseError(path, "is locked", "wait"))
    assert "/some/?.sqlite: is locked" in ErrorMessage.decode(message.encode()).message


@pytest.mark.parametrize("name", CASES)
def test_every_attribute_is_documented(name: str) -> None:
    documented = "".join(kind.__doc__ or "" for kind in every_class()[name].__mro__)
    for attribute in CASES[name][1]:
        assert f"{attribute}: " in documented


def test_wrong_values_are_value_errors_and_missing_fields_key_errors() -> None:
    assert issubclass(exceptions.InvalidValue, ValueError)
    assert issubclass(exceptions.MalformedMessage, ValueError)
    assert issubclass(exceptions.UnknownField, KeyError)


def test_versions_and_layouts_are_malformed_messages() -> None:
    assert issubclass(exceptions.UnsupportedVersion, exceptions.MalformedMessage)
    assert issubclass(exceptions.LayoutMismatch, exceptions.MalformedMessage)


def test_unknown_field_reads_like_the_others() -> None:
    # KeyError would put the message in quotes
    assert str(exceptions.UnknownField("a", ["b"])) == "no field 'a'; there are b"


def test_a_robot_file_error_without_a_field_is_about_the_file() -> None:
    error = exceptions.RobotFileError(HERE, "", "is empty", "YAML")
    assert f"{HERE}: file: is empty" in str(error)


def test_a_long_compiler_output_is_kept_whole_and_shown_in_part() -> None:
    output = "\n".join(f"line {index}." for index in range(100))
    error = exceptions.CompilationFailed(["gcc"], output)
    assert error.output == output
    assert "line 99." in str(error)
    assert "line 50." not in str(error)


def test_errors_survive_pickling_as_multiprocessing_does() -> None:
    for name, (arguments, attributes, _) in CASES.items():
        error = pickle.loads(pickle.dumps(every_class()[name](*arguments)))
        assert {key: getattr(error, key) for key in attributes} == attributes
