from __future__ import annotations

import pytest

from tsd_experiments.beyond.trusted_regression.__main__ import main
from tsd_experiments.beyond.trusted_regression.rows import predict_from_few

ROWS = ("15 entries, with corners", "2-D, 3 entries", "two entries 1 um apart", "1-D, 4 entries")


def test_the_rows_of_few_entries_are_told() -> None:
    goals = predict_from_few(range(2))
    assert len(goals) == 4
    assert all(goal.measured is not None and goal.measured > 0 for goal in goals)


@pytest.mark.long
def test_the_short_form_prints_every_row(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.argv", ["trusted_regression", "--quick"])
    main()
    told = capsys.readouterr().out
    for row in ROWS:
        assert row in told
