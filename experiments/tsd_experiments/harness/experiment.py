"""What every experiment offers: the jobs it is made of, and what it reports of them."""

from __future__ import annotations

import abc
from collections.abc import Mapping

from tsd_experiments.harness.job import Job, Result
from tsd_experiments.harness.section import Section

Done = Mapping[str, Result]


class Experiment(abc.ABC):
    """Some jobs and what follows from them.

    Attributes:
        name: First part of its jobs' names.
        figures: Numbers of the paper's figures that it reproduces.
    """

    name: str
    figures: tuple[int, ...] = ()

    def __init__(self, quick: bool) -> None:
        """Choose the short form or the full one."""
        self.quick = quick

    @abc.abstractmethod
    def jobs(self, done: Done) -> list[Job]:
        """Name all jobs that can be named with the results so far.

        Args:
            done: Finished jobs of this and other experiments by name.
        """

    @abc.abstractmethod
    def report(self, done: Done) -> Section:
        """Write the experiment's part of the report."""
