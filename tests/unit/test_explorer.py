from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.learned_squats import AMPLITUDES, AXES, CONTEXT, FREQUENCY, learn_squats
from tsd_casadi.database.database import Database
from tsd_casadi.exceptions import ServiceUnreachable
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.motions.parameter import Parameter
from tsd_casadi.wire.feedforward import FeedforwardMessage
from tsd_casadi.wire.learner import DatabaseReply, EntryMessage, entry_messages
from tsd_clients.viewer.explorer import Asked, Explorer
from tsd_clients.viewer.known_motion import KnownMotion, known_motions
from tsd_clients.viewer.learner_link import LearnerLink
from tsd_clients.viewer.parameter_slider import ParameterSlider
from tsd_clients.viewer.prediction import PHASE

ROBOT = "hermes_lower"


class LocalLearner:
    """A database that answers as a learner service does."""

    def __init__(self, database: Database) -> None:
        self._database = database
        self.asked: list[dict[str, Any]] = []

    def query(self, motion: str, /, **given: Any) -> Feedforward:
        self.asked.append(given)
        message = FeedforwardMessage.of(ROBOT, motion, self._database.query(motion, **given))
        return FeedforwardMessage.decode(message.encode()).feedforward()

    def entries(self) -> list[EntryMessage]:
        return entry_messages(self._database.outlines().entries)

    def database(self, *, limit: int) -> DatabaseReply:
        page = self._database.outlines(most=limit)
        return DatabaseReply(database="here", entries=entry_messages(page.entries), more=page.more)


@pytest.fixture(scope="module")
def squats(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    path = tmp_path_factory.mktemp("explorer") / "squats.sqlite"
    learn_squats(path)
    return path


@pytest.fixture
def learner(squats: Path) -> Iterator[LocalLearner]:
    with Database(squats) as database:
        yield LocalLearner(database)


@pytest.fixture
def explorer(learner: LocalLearner) -> Explorer:
    explorer = Explorer(learner)
    assert explorer.refresh()
    return explorer


def at(known: KnownMotion, amplitude: float, **options: Any) -> Asked:
    parameters = {"amplitude": amplitude, "frequency": FREQUENCY, "height": 0.0}
    return Asked(known, parameters, **options)


def test_what_can_be_generalised_together_is_one_motion(explorer: Explorer) -> None:
    (known,) = explorer.motions
    assert (known.robot, known.motion, known.axes) == (ROBOT, "squat", AXES)
    assert known.context == CONTEXT
    assert [each.parameters["amplitude"].value for each in known.entries] == [*AMPLITUDES]
    other = [
        entry.model_copy(update={"robot": "g1", "updated": "2999", "entry": entry.entry + 100})
        for entry in known.entries[:2]
    ]
    nothing_learned = known.entries[0].model_copy(update={"motion": "sway", "served": 0})
    found = known_motions([*known.entries, *other, nothing_learned])
    assert [(each.robot, len(each.entries)) for each in found] == [("g1", 2), (ROBOT, 5)]


def test_a_slider_spans_the_entries_and_some_of_what_is_refused(explorer: Explorer) -> None:
    (known,) = explorer.motions
    amplitude, frequency, height = known.sliders(explorer.declaration(known))
    assert (amplitude.name, amplitude.unit) == ("amplitude", "m")
    assert amplitude.meaning == "half of peak to peak"
    assert (amplitude.learned_low, amplitude.learned_high) == (0.02, 0.08)
    assert 0 < amplitude.low < 0.02 < 0.08 < amplitude.high < 0.1
    # in the middle of the widest gap: something to predict
    assert amplitude.start == 0.07
    assert frequency.is_movable and not frequency.varies
    # all of them have none of it: nothing to choose
    assert not height.is_movable


@given(
    st.lists(st.integers(1, 100), min_size=1, max_size=6, unique=True),
    st.sampled_from([1e-3, 0.005, 0.1]),
)
def test_a_slider_stands_at_every_entry(numbers: list[int], digit: float) -> None:
    values = [round(number * digit, 6) for number in numbers]
    slider = ParameterSlider.over(Parameter("amplitude", "m", low=0.0), values)
    assert 0 < slider.low <= min(values) <= slider.start <= max(values) <= slider.high
    assert slider.low < slider.high
    for value in values:
        steps = (value - slider.low) / slider.step
        assert steps == pytest.approx(round(steps), abs=1e-3)


def test_a_slider_stays_in_the_motions_range() -> None:
    parameter = Parameter("amplitude", "m", low=0.015, high=0.085)
    slider = ParameterSlider.over(parameter, [0.02, 0.08])
    assert (slider.low, slider.high) == (0.015, 0.085)
    # values that have nothing round in common: steps are round all the same
    odd = ParameterSlider.over(Parameter("amplitude", "m"), [0.020001, 0.0799])
    assert odd.step == 0.001


def test_the_answer_is_the_learners_with_both_bands(
    explorer: Explorer, learner: LocalLearner
) -> None:
    (known,) = explorer.motions
    prediction = explorer.predict(at(known, 0.05))
    direct = learner.query("squat", robot=ROBOT, amplitude=0.05, frequency=FREQUENCY)
    assert prediction.refusal == ""
    assert prediction.exact is None
    for index, axis in enumerate(AXES):
        curve = prediction.over_phase(axis)
        assert curve is not None
        np.testing.assert_allclose(curve, direct.mean(PHASE)[index], atol=1e-12)
        pointwise, whole = (prediction.band(k, axis) for k in ("pointwise", "simultaneous"))
        assert pointwise is not None and whole is not None
        half = direct.basis.evaluate(PHASE, direct.bands[0].half_width)[index]
        np.testing.assert_allclose(pointwise[1] - curve, half, atol=1e-12)
        assert (whole[0] < pointwise[0]).all() and (pointwise[1] < whole[1]).all()
    assert [curve.entry.entry for curve in prediction.around] == [3, 4, 2, 5]
    assert prediction.origin == "from entries 1, 2, 3, 4, 5"
    assert any("bounded" in note for note in prediction.notes())


def test_where_an_entry_is_the_user_chooses(explorer: Explorer) -> None:
    (known,) = explorer.motions
    learned = explorer.predict(at(known, 0.045))
    assert learned.exact == 3
    assert learned.feedforward is not None and learned.feedforward.kind == "learned"
    assert learned.band("pointwise", "com.z") is None
    assert learned.origin == "entry 3 is exactly there, iteration 3"
    predicted = explorer.predict(at(known, 0.045, kind="generalised"))
    assert predicted.feedforward is not None and predicted.feedforward.kind == "generalised"
    assert predicted.origin == "from entries 1, 2, 4, 5"


def test_a_refusal_has_its_reason_and_can_be_overridden(explorer: Explorer) -> None:
    (known,) = explorer.motions
    refused = explorer.predict(at(known, 0.09))
    assert refused.feedforward is None and refused.is_beyond
    assert "outside the learned range 0.02 to 0.08 m" in refused.refusal
    assert refused.over_phase("com.z") is None and refused.notes() == []
    assert len(refused.around) == 4
    assert explorer.predict(at(known, 0.09, extrapolate=True)).refusal == ""
    elsewhere = replace(at(known, 0.05), parameters={**at(known, 0.05).parameters, "height": 0.1})
    other = explorer.predict(replace(elsewhere, extrapolate=True))
    # no entry differs in it: nothing to extrapolate from
    assert "has height 0 m" in other.refusal and not other.is_beyond


def test_entries_that_disagree_are_named(tmp_path: Path) -> None:
    path = tmp_path / "wrong.sqlite"
    learn_squats(path, [0.02, 0.03, 0.04, 0.05, 0.06, 0.07, 0.08], iterations=1, wrong=0.05)
    with Database(path) as database:
        explorer = Explorer(LocalLearner(database))
        explorer.refresh()
        prediction = explorer.predict(at(explorer.motions[0], 0.045))
    (said,) = prediction.disagreeing
    assert said.startswith("entry 4 disagrees")
    assert 4 not in (prediction.feedforward or pytest.fail()).provenance["entries"]


def test_curves_of_entries_are_asked_for_once(explorer: Explorer, learner: LocalLearner) -> None:
    (known,) = explorer.motions
    explorer.predict(at(known, 0.05))
    before = len(learner.asked)
    explorer.predict(at(known, 0.0505))
    assert len(learner.asked) == before + 1


def test_it_lists_again_only_when_something_was_recorded(squats: Path, tmp_path: Path) -> None:
    path = tmp_path / "more.sqlite"
    path.write_bytes(squats.read_bytes())
    with Database(path) as database:
        explorer = Explorer(LocalLearner(database))
        assert explorer.refresh()
        assert not explorer.refresh()
        database.forget(5)
        assert explorer.refresh()
        assert len(explorer.motions[0].entries) == 4
        learn_squats(path, [0.1], iterations=1)
        assert explorer.refresh()
        assert len(explorer.motions[0].entries) == 5


def wait_until(done: Callable[[], object], seconds: float = 30.0) -> None:
    end = time.monotonic() + seconds
    while not done():
        assert time.monotonic() < end
        time.sleep(0.005)


class SlowLearner(LocalLearner):
    """Answers when it is told to, so that questions pile up."""

    def __init__(self, database: Database) -> None:
        super().__init__(database)
        self.go, self.came = threading.Semaphore(0), threading.Event()
        self.answered: list[float] = []

    def query(self, motion: str, /, **given: Any) -> Feedforward:
        if given["kind"] is None:
            self.came.set()
            self.go.acquire(timeout=30)
            self.answered.append(given["amplitude"])
        return super().query(motion, **given)


def test_of_questions_that_pile_up_only_the_newest_is_answered(squats: Path) -> None:
    made: list[SlowLearner] = []

    @contextmanager
    def open_learner() -> Iterator[SlowLearner]:
        with Database(squats) as database:
            made.append(SlowLearner(database))
            yield made[-1]

    link = LearnerLink(open_learner)
    try:
        wait_until(lambda: link.listed)
        (known,) = link.motions
        link.ask(at(known, 0.03))
        assert made[0].came.wait(30)
        for amplitude in np.linspace(0.031, 0.06, 30).tolist():
            link.ask(at(known, amplitude))
        for _ in range(3):
            made[0].go.release()
        wait_until(lambda: link.prediction and link.prediction[0].parameters["amplitude"] == 0.06)
    finally:
        link.close()
    assert made[0].answered == [0.03, 0.06]


def test_a_learner_that_was_gone_answers_what_was_asked_meanwhile(squats: Path) -> None:
    gone = threading.Event()
    gone.set()

    class Unreachable(LocalLearner):
        def database(self, *, limit: int) -> DatabaseReply:
            if gone.is_set():
                raise ServiceUnreachable("learner", ["tcp/127.0.0.1:1"], "no reply")
            return super().database(limit=limit)

    @contextmanager
    def open_learner() -> Iterator[LocalLearner]:
        with Database(squats) as database:
            yield Unreachable(database)

    with Database(squats) as database:
        explorer = Explorer(LocalLearner(database))
        explorer.refresh()
    link = LearnerLink(open_learner)
    try:
        wait_until(lambda: "no reply" in link.trouble)
        link.ask(at(explorer.motions[0], 0.05))
        gone.clear()
        wait_until(lambda: link.prediction)
        assert link.trouble == ""
        link.look_at(explorer.motions[0].entries[1])
        wait_until(lambda: link.curve)
        assert link.curve is not None and link.curve.entry.entry == 2
    finally:
        link.close()
