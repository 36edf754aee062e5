"""What becomes of a thousand recordings as no robot makes them.

Run: python -m benchmarks.abuse [--records N] [--falls N] [--seed N] [--json FILE]

An honest recording of a squat of the simulated robot, 10 % too heavy in the controller's
model, is spoilt in twelve ways, each more or less, and handed to a learner as it would come
over the network: half of the time to one that knows nothing of the motion, half of the time
to one that has learned it. A record is refused with a reason, or what is served afterwards is
within its bound, which is compared with the samples that were recorded. Of every kind the
terms that changed most are fed forward in the simulation.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from random import Random
from typing import Any

import numpy as np

from benchmarks.abusive_records import KINDS, abuse
from tsd_casadi.database.database import Database
from tsd_casadi.exceptions import TsdError
from tsd_casadi.learning.bound import peak
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.learning.instruction import Instruction
from tsd_casadi.learning.recording import Recording
from tsd_casadi.wire.record import RecordMessage

# samples of a lap that are sent: messages of a tenth of a megabyte
SAMPLES = 250
# of rounding on the way
SLACK = 1 + 1e-9


@dataclass(frozen=True)
class Outcome:
    """What became of one record.

    Attributes:
        kind: Of the abuse.
        refusal: Why it was refused; empty if it was not.
        served: What is served afterwards; None if it was refused.
        is_within: Whether that is within the bound, and the bound within what was recorded.
    """

    kind: str
    refusal: str = ""
    served: Feedforward | None = None
    is_within: bool = True


def thin(recording: Recording, samples: int = SAMPLES) -> Recording:
    """Keep some samples of each lap."""
    laps = []
    for lap in recording.laps:
        keep = np.linspace(0, lap.phase.size - 1, min(samples, lap.phase.size)).astype(int)
        assert lap.error is not None
        assert lap.reference is not None
        laps.append(
            replace(
                lap,
                phase=lap.phase[keep],
                feedback=lap.feedback[:, keep],
                error=lap.error[:, keep],
                reference=lap.reference[:, keep],
                feedforward=None,
            )
        )
    return replace(recording, laps=laps)


def outcomes(honest: Recording, records: int, seed: int, folder: Path) -> Iterator[Outcome]:
    """Hand over abusive records, one kind after another.

    Args:
        honest: What they are made of.
        records: Number of them.
        folder: For the database.
    """
    chance, robot = Random(seed), honest.key.robot
    fields = RecordMessage.of(honest).model_dump(mode="json")
    with Database(folder / "abused.sqlite") as database:
        for index in range(records):
            kind = list(KINDS)[index % len(KINDS)]
            database.record(honest, Instruction(restart=True))
            document = abuse(fields, kind, chance)
            document["restart"] = chance.random() < 0.5
            yield _hand_over(database, document, robot, kind)


def _hand_over(database: Database, document: dict[str, Any], robot: str, kind: str) -> Outcome:
    before = len(database.entries())
    try:
        message = RecordMessage.decode(json.dumps(document).encode())
        recording = message.recording(robot)
        entry, _ = database.record(recording, message.instruction())
    except TsdError as error:
        # nothing stored
        return Outcome(kind, str(error), is_within=len(database.entries()) == before)
    key = entry.key
    served = database.query(
        key.motion, robot=robot, kind="learned", context=key.context, **dict(key.parameters)
    )
    found = peak(served.weights, served.basis)
    limit = _recorded(recording)
    return Outcome(kind, "", served, bool((found <= SLACK * limit).all()))


def _recorded(recording: Recording) -> Any:
    """Compute the bound anew, from the samples of this record and of the honest one, (k,)."""
    samples = [
        np.abs(lap.feedback + recording.basis.evaluate(lap.phase, recording.applied)).max(axis=1)
        for lap in recording.laps
    ]
    allowed = recording.circumstances.allowed or np.inf
    return np.minimum(1.5 * np.max(samples, axis=0), allowed)


def falls(served: Feedforward, simulator: Any, controller: Any, motion: Any) -> bool:
    """Say whether the simulated robot falls with a feedforward."""
    from tsd_casadi.repetition.repeat import repeat

    return repeat(simulator, controller, motion, laps=2, feedforward=served).fell


def main() -> None:
    """Abuse and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--records", type=int, default=1_000)
    parser.add_argument("--falls", type=int, default=2, help="of each kind, in the simulation")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()

    from tsd_casadi.compilation.compile_controller import compile_controller
    from tsd_casadi.motions.squat import Squat
    from tsd_casadi.repetition.record import record_of
    from tsd_casadi.repetition.repeat import repeat
    from tsd_casadi.robot.robot import load_robot
    from tsd_clients.simulator.model_error import ModelError
    from tsd_clients.simulator.simulator import MujocoSimulator

    robot = load_robot("hermes_lower")
    controller, motion = compile_controller(robot), Squat(0.03, 0.5)
    simulator = MujocoSimulator(robot, model_error=ModelError(0.1))
    honest = thin(record_of(repeat(simulator, controller, motion, laps=4), robot))
    with tempfile.TemporaryDirectory() as folder:
        found = list(outcomes(honest, arguments.records, arguments.seed, Path(folder)))
    rows = {}
    for kind in KINDS:
        of_kind = [each for each in found if each.kind == kind]
        accepted = [each.served for each in of_kind if each.served is not None]
        accepted.sort(key=lambda each: -float(peak(each.weights, each.basis).max()))
        fell = sum(
            falls(each, simulator, controller, motion) for each in accepted[: arguments.falls]
        )
        rows[kind] = {
            "records": len(of_kind),
            "refused": sum(bool(each.refusal) for each in of_kind),
            "within the bound": sum(each.is_within for each in of_kind if not each.refusal),
            "neither": sum(not each.is_within for each in of_kind),
            "simulated": min(len(accepted), arguments.falls),
            "fell": fell,
            "example": next((each.refusal for each in of_kind if each.refusal), ""),
        }
        print(f"{kind}: " + ", ".join(f"{n} {v}" for n, v in rows[kind].items() if n != "example"))
        print(f"    {str(rows[kind]['example'])[:150]}")
    good = sum(each.is_within for each in found)
    print(
        f"{good} of {len(found)} refused or within the bound; "
        f"{sum(int(row['fell']) for row in rows.values())} falls"  # type: ignore[call-overload]
    )
    if arguments.json:
        arguments.json.write_text(json.dumps(rows, indent=2))


if __name__ == "__main__":
    main()
