"""Where finished jobs are kept, so that each is done once."""

from __future__ import annotations

import json
from pathlib import Path
from zipfile import BadZipFile

import numpy as np

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.robot.robot import Robot
from tsd_experiments.harness.duration import Span
from tsd_experiments.harness.job import Job, Result
from tsd_experiments.harness.outcome import Outcome


class Store:
    """Finished jobs of one robot in one folder.

    Attributes:
        folder: The folder.
    """

    def __init__(self, folder: Path, robot: Robot) -> None:
        """Open the folder, make it if need be.

        Raises:
            InvalidValue: If it cannot be written.
        """
        self.folder = folder
        self.robot = robot
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InvalidValue(
                "the folder for results",
                f"'{folder}' ({error.strerror})",
                "one that you may write to; choose another with --out",
            ) from error

    def load(self, job: Job) -> Result | None:
        """Read the result of a job that was finished with the same arguments."""
        described = self.folder / f"{job.name}.json"
        try:
            document = json.loads(described.read_text())
            if document["fingerprint"] != job.fingerprint(self.robot):
                return None
            # opened here: numpy leaves a damaged file open
            with (self.folder / f"{job.name}.npz").open("rb") as file, np.load(file) as stored:
                begin, end = document["span"]
                return Result(document["rows"], dict(stored), (begin, end))
        except (OSError, ValueError, KeyError, BadZipFile):
            return None  # not done, or half written: do it again

    def save(self, job: Job, outcome: Outcome, span: Span) -> Result:
        """Keep an outcome; the description comes last and says that all is there."""
        described = self.folder / f"{job.name}.json"
        # an older description must not be found beside newer arrays
        described.unlink(missing_ok=True)
        np.savez_compressed(self.folder / f"{job.name}.npz", **outcome.arrays)  # type: ignore[arg-type]
        document = {
            "fingerprint": job.fingerprint(self.robot),
            "function": job.function_name,
            "arguments": job.arguments,
            "span": span,
            "rows": outcome.rows,
        }
        part = self.folder / f"{job.name}.json.part"
        part.write_text(json.dumps(document))
        part.rename(described)
        return Result(outcome.rows, outcome.arrays, span)
