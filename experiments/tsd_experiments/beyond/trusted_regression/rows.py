"""The rows of the table: what predictions are worth from few entries, and from wrong ones."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tsd_experiments.beyond.trusted_regression.designs import CURVES, Design
from tsd_experiments.beyond.trusted_regression.fixed_methods import FIXED, interpolate_linearly
from tsd_experiments.beyond.trusted_regression.learned_terms import load_terms
from tsd_experiments.harness.section import Goal

HELD_OUT = 30
ALL = 1_000
# of a pair that contradicts itself
OFF_BY = 1.1
OPPOSITE = -1.0
# numbers of entries whose coverage is told, by the number of parameters
COVERED = {1: (4, 6, 8), 2: (4, 6, 8, 12), 3: (4, 6, 8, 10, 15, 30)}


def compare_with_fixed(seeds: Sequence[int]) -> tuple[list[Goal], list[list[str]]]:
    """Compare with the best of the fixed methods, 15 entries along three parameters.

    Returns:
        Goals, and rows with the median errors of all [mm/s^2].
    """
    goals, rows = [], []
    for corners, name, median in ((True, "with corners", 0.8), (False, "random", 0.9)):
        designs = [
            Design.draw(load_terms()[3][0], 15, seed, corners=corners, most=HELD_OUT)
            for seed in seeds
        ]
        ours = np.array([each.error(each.predicted(each.regression())[0]) for each in designs])
        fixed = {
            key: np.array([d.error_of(method) for d in designs]) for key, method in FIXED.items()
        }
        best = min(fixed, key=lambda key: float(np.median(fixed[key])))
        ratio = ours / fixed[best]
        goals += [
            Goal(
                f"3-D, 15 {name}: error / best fixed ({best}), median", f"<= {median}", _mid(ratio)
            ),
            Goal(f"3-D, 15 {name}: error / best fixed ({best}), worst", "<= 1.1", max(ratio)),
        ]
        errors = [*fixed.values(), ours]
        rows.append([f"15 entries, {name}", *(f"{1e3 * _mid(each):.2f}" for each in errors)])
    return goals, rows


def predict_from_few(seeds: Sequence[int]) -> list[Goal]:
    """Compare with linear interpolation, three and four entries along two parameters."""
    goals = []
    for entries in (3, 4):
        ratios = []
        for seed in seeds:
            design = Design.draw(
                load_terms()[2][0], entries, seed, corners=False, most=ALL
            ).inside()
            if len(design.asked):
                ours = design.error(design.predicted(design.regression())[0])
                ratios.append(ours / design.error_of(interpolate_linearly))
        name = f"2-D, {entries} entries: error / linear"
        goals += [
            Goal(f"{name}, median", "<= 1.0", _mid(ratios)),
            Goal(f"{name}, worst", "<= 1.3", max(ratios)),
        ]
    return goals


def contradict(seeds: Sequence[int]) -> list[Goal]:
    """Add an entry a micrometre beside another that differs by 10 %, or has the opposite sign."""
    goals = []
    for parameters in (2, 3):
        ratios, wrong, named, alarms = [], 0, 0, 0
        for seed in seeds:
            rng = np.random.default_rng(seed)
            entries = int(rng.integers(6, 11))
            alone = Design.draw(
                load_terms()[parameters][0], entries - 1, seed, corners=False, most=ALL
            )
            beside = int(rng.integers(entries - 1))
            pair = alone.repeated(beside, OFF_BY)
            predicted, _ = pair.predicted(pair.regression())
            ratios.append(pair.error(predicted) / pair.error_of(interpolate_linearly))
            opposite = alone.repeated(beside, OPPOSITE)
            regression = opposite.regression()
            wrong += pair.wrong_signs(predicted)
            wrong += opposite.wrong_signs(opposite.predicted(regression)[0])
            named += set(regression.disagreeing) == {entries - 1}
            alarms += len(alone.regression().disagreeing)
        name = f"{parameters}-D"
        goals += [
            Goal(f"{name}, two entries 1 um apart: error / linear, median", "<= 1.0", _mid(ratios)),
            Goal(f"{name}, two entries 1 um apart: error / linear, worst", "<= 2.0", max(ratios)),
            Goal(f"{name}, those and opposite ones: wrong signs", "<= 0", float(wrong)),
            Goal(
                f"{name}, opposite entries named, and no other [%]",
                ">= 100",
                100 * named / len(seeds),
            ),
            Goal(f"{name}, entries named in designs without any wrong", "<= 0", float(alarms)),
        ]
    return goals


def cover(seeds: Sequence[int]) -> list[Goal]:
    """Count points within two deviations, and whole curves within the simultaneous band."""
    goals = []
    for parameters, numbers in COVERED.items():
        for entries in numbers:
            points, curves = [], []
            for seed in seeds:
                known = load_terms()[parameters]
                terms = known[seed // 2 % len(known)]
                # every second one has the corners, where there are enough for them
                corners = bool(seed % 2) and entries > len(terms.corners)
                design = Design.draw(terms, entries, seed, corners=corners, most=ALL).inside()
                if not len(design.asked):
                    continue
                regression = design.regression()
                mean, deviation = design.predicted(regression)
                off = np.abs((mean - design.wanted) @ CURVES)
                pointwise, simultaneous = (
                    np.array(
                        [regression.bands(each[None])[kind].half_width[0] for each in deviation]
                    )
                    for kind in (0, 1)
                )
                points.append(off <= pointwise @ CURVES)
                curves.append(np.all(off <= simultaneous @ CURVES, axis=1))
            inside = 100 * float(np.mean(np.concatenate(points)))
            whole = 100 * float(np.mean(np.concatenate(curves)))
            name = f"{parameters}-D, {entries} entries"
            goals += [
                Goal(f"{name}: points within two deviations [%]", "92 .. 98", inside),
                Goal(f"{name}: curves within the band [%]", ">= 90", whole),
            ]
    return goals


def _mid(values: Sequence[float] | np.ndarray) -> float:
    return float(np.median(values))
