"""What learning does to the true centre of mass when the masses of links are off one by one.

Run: python -m benchmarks.true_error [--seeds N] [--link-error E] [--iterations N]

Learns a squat for each draw of the links' errors; the error that the controller sees and
the true one, before and after, beside what is said at the prompt of a robot that nobody
has measured.
"""

from __future__ import annotations

import argparse

import numpy as np

from tsd_casadi.center_of_mass.prior_deviation import prior_deviation
from tsd_casadi.compilation.compile_controller import compile_controller
from tsd_casadi.robot.robot import load_robot
from tsd_clients.console.progress import show_progress
from tsd_clients.console.table import Column, console, print_table
from tsd_experiments.harness.case import Case
from tsd_experiments.harness.learn_case import learn_case


def main() -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--seeds", type=int, default=10, help="draws of the links' errors")
    parser.add_argument("--link-error", type=float, default=0.1, help="of each link's mass")
    parser.add_argument("--iterations", type=int, default=2)
    arguments = parser.parse_args()
    robot = load_robot("hermes_lower")
    controller = compile_controller(robot)
    found = []
    with show_progress("true error", float(arguments.seeds)) as report:
        for seed in range(arguments.seeds):
            case = Case(
                frequency=0.5, model_error=0.0, link_error=arguments.link_error, link_seed=seed
            )
            rows = learn_case(
                robot, controller, case.plain(), rule="guarded", iterations=arguments.iterations
            ).rows
            found.append(
                [
                    1e3 * row[f"{which}rms_error_m"]
                    for which in ("", "true_")
                    for row in (rows[0], rows[-1])
                ]
            )
            report(seed + 1.0, float(arguments.seeds))
    errors = np.array(found)
    names = ("seen,\nbefore", "seen,\nafter", "true,\nbefore", "true,\nafter")
    columns = [Column("seed", [str(seed) for seed in range(arguments.seeds)])]
    columns += [
        Column(name, [f"{value:.3g}" for value in values])
        for name, values in zip(names, errors.T, strict=True)
    ]
    print_table("RMS error along com.z [mm]", columns)
    before, after = np.median(errors[:, 2:], axis=0)
    deviation = 1e3 * np.linalg.norm(prior_deviation(robot, robot.home.q))
    console.print(
        f"larger in {(errors[:, 3] > errors[:, 2]).sum()} of {len(errors)}, median {before:.1f} to "
        f"{after:.1f} mm; said at the prompt: {deviation:.2g} mm",
        highlight=False,
    )


if __name__ == "__main__":
    main()
