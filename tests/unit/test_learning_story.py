from __future__ import annotations

import numpy as np
import pytest

from benchmarks.learned_squats import AXES, learn_squats
from tsd_casadi.database.database import Database
from tsd_casadi.learning.contraction import Contraction
from tsd_casadi.learning.entry import Entry
from tsd_casadi.wire.basis import BasisMessage
from tsd_casadi.wire.learner import EntryMessage
from tsd_casadi.wire.telemetry import IterationRecorded
from tsd_clients.viewer.learning_lines import error_chart, share_lines, weight_lines
from tsd_clients.viewer.learning_story import SMALLEST, ErrorHistory, told
from tsd_clients.viewer.prediction import PHASE, LearnedCurve


@pytest.fixture(scope="module")
def squat(tmp_path_factory: pytest.TempPathFactory) -> Entry:
    path = tmp_path_factory.mktemp("story") / "squat.sqlite"
    learn_squats(path, [0.04])
    with Database(path) as database:
        (entry,) = database.entries()
    return entry


@pytest.fixture
def entry(squat: Entry) -> EntryMessage:
    return EntryMessage.of(squat)


@pytest.fixture
def changed(entry: EntryMessage) -> EntryMessage:
    """The same, as if the robot had changed after the second iteration."""
    later = [each.model_copy(update={"epoch": int(each.number >= 2)}) for each in entry.iterations]
    return entry.model_copy(update={"iterations": later})


def recorded_of(entry: Entry, before: int) -> IterationRecorded:
    contraction = next(iter(entry.contractions))
    return IterationRecorded(
        number=1,
        repetition=1,
        entry=entry.identifier,
        motion="squat",
        parameters=dict(entry.key.parameters),
        axes=entry.key.axes,
        iteration=before,
        errors={},
        basis=BasisMessage.of(entry.basis),
        before=entry.iterations[before].weights.tolist(),
        after=entry.iterations[before + 1].weights.tolist(),
        served=before + 1,
        learning_gain=1.0,
        rule="guarded",
        contractions=(contraction,),
        notes=["a remark"],
    )


def test_errors_come_with_how_well_they_repeat(entry: EntryMessage, squat: Entry) -> None:
    history = ErrorHistory.of(entry.iterations, "com.z")
    errors = [(each.errors or {})["com.z"] for each in squat.iterations]
    assert history.number.tolist() == [0, 1, 2, 3]
    assert history.rms.tolist() == [each.rms for each in errors]
    low, high = history.repeatability
    assert history.has_deviation
    np.testing.assert_allclose(high, [each.rms + (each.deviation or 0) for each in errors])
    assert (low > 0).all() and (low < history.rms).all()
    assert history.epochs_begin == []


def test_an_error_of_nothing_has_a_place_on_a_logarithmic_axis(entry: EntryMessage) -> None:
    last = entry.iterations[-1]
    nothing = {
        name: each.model_copy(update={"rms": 0.0, "deviation": None})
        for name, each in (last.errors or {}).items()
    }
    untested = last.model_copy(update={"number": 4, "errors": None})
    iterations = [last.model_copy(update={"errors": nothing}), untested]
    history = ErrorHistory.of(iterations, "com.z")
    assert history.rms[0] == SMALLEST and np.isnan(history.rms[1])
    assert not history.has_deviation
    x, lines, shades = error_chart({"com.z": history})
    assert shades == [] and len(lines) == 1 and x.tolist() == [3, 4]


def test_lines_are_in_thousandths_with_a_shade_each(entry: EntryMessage) -> None:
    histories = {axis: ErrorHistory.of(entry.iterations, axis) for axis in AXES}
    x, lines, shades = error_chart(histories)
    assert [line.label for line in lines] == [*AXES]
    assert len(shades) == 2
    np.testing.assert_allclose(lines[1].values, 1e3 * histories["com.z"].rms)
    assert x.tolist() == [0, 1, 2, 3]


def test_epochs_have_lines_of_their_own_and_a_mark_between(changed: EntryMessage) -> None:
    history = ErrorHistory.of(changed.iterations, "com.z")
    assert history.epochs_begin == [1.5]
    x, lines, _ = error_chart({"com.z": history})
    assert [line.label for line in lines] == ["com.z", "com.z, epoch 1", "the robot changed"]
    before, after, mark = lines
    assert x[np.isfinite(before.values)].tolist() == [0, 1]
    assert x[np.isfinite(after.values)].tolist() == [2, 3]
    np.testing.assert_allclose(x[np.isfinite(mark.values)], 1.5, atol=2e-3)
    assert np.ptp(mark.values[np.isfinite(mark.values)]) > 0
    assert any("changed 1" in each for each in told(changed, None))


def test_true_errors_have_a_line_where_they_are_others(entry: EntryMessage) -> None:
    def labels(factor: float) -> list[str]:
        iterations = [
            each.model_copy(
                update={
                    "errors": {
                        name: error.model_copy(update={"true_rms": factor * error.rms})
                        for name, error in (each.errors or {}).items()
                    }
                }
            )
            for each in entry.iterations
        ]
        _, lines, _ = error_chart({"com.z": ErrorHistory.of(iterations, "com.z")})
        return [line.label for line in lines]

    assert labels(1.019) == ["com.z"]
    assert labels(1.021) == ["com.z", "com.z, true"]


def test_weights_before_and_after_are_curves_over_the_phase(squat: Entry) -> None:
    recorded = recorded_of(squat, before=1)
    before, after = weight_lines("com.z", recorded, None)
    assert (before.label, after.label) == ("before, iteration 1", "after, iteration 2")
    row = AXES.index("com.z")
    for line, iteration in ((before, 1), (after, 2)):
        curve = squat.basis.evaluate(PHASE, squat.iterations[iteration].weights)[row]
        np.testing.assert_allclose(line.values, curve, atol=1e-12)
    # nothing is served from then on: what was in use stays
    same = weight_lines("com.z", recorded.model_copy(update={"after": None}), None)
    np.testing.assert_array_equal(same[0].values, same[1].values)


def test_of_what_nobody_watched_what_is_served_is_shown(squat: Entry, entry: EntryMessage) -> None:
    curve = LearnedCurve(entry, squat.feedforward())
    (line,) = weight_lines("com.x", None, curve)
    assert line.label == "iteration 3, served"
    assert weight_lines("com.x", None, None) == []
    assert weight_lines("com.y", None, curve) == []


def test_harmonics_are_those_of_the_axis_as_far_as_they_are_known(squat: Entry) -> None:
    recorded = recorded_of(squat, before=2)
    lines = {line.label: line.values for line in share_lines("com.x", recorded)}
    contraction: Contraction = recorded.contractions[0]
    np.testing.assert_array_equal(lines["plain sum"], contraction.plain)
    known = np.array([each is not None for each in contraction.predicted])
    np.testing.assert_array_equal(np.isfinite(lines["predicted"]), known)
    assert share_lines("com.z", recorded) == [] == share_lines("com.x", None)


def test_it_is_told_how_far_the_error_came_down(squat: Entry, entry: EntryMessage) -> None:
    said = told(entry, recorded_of(squat, before=2))
    first, last = squat.iterations[0].errors or {}, squat.iterations[-1].errors or {}
    wanted = f"com.z: {1e3 * first['com.z'].rms:.3g} → {1e3 * last['com.z'].rms:.3g} mm RMS"
    assert wanted in said
    assert said[-1] == "a remark"
