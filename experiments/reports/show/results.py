"""What a folder of results holds, and what of it can be shown."""

import dataclasses
import functools
import pathlib

import numpy as np
from jaxtyping import Float

from experiments.studies.runs_file import read_runs
from identification.result.parameters_file import read_parameters
from scdpr_jax.robot.parameters import Robot
from tuning.result.document import read_tuning
from tuning.result.tuning import Tuning

REPORT, PARAMETERS, TUNING, RUNS = "report.html", "parameters.json", "tuning.json", "runs.csv"
"""Files that are known by their names."""

MOST_FILES = 500
"""Files that are offered: a folder with more is no folder of results."""


@dataclasses.dataclass(frozen=True)
class Results:
    """A folder of results, which is only read."""

    folder: pathlib.Path
    """The folder."""

    @property
    def files(self) -> dict[str, pathlib.Path]:
        """The files that are offered, by their paths inside the folder.

        Whatever is asked for is looked up here: a path that leads out of the folder isn't in
        it, nor is a link that does.
        """
        root = self.folder.resolve()
        inside = {
            path.relative_to(self.folder).as_posix(): path
            for path in sorted(self.folder.rglob("*"))
            if path.is_file() and path.resolve().is_relative_to(root)
        }
        return {
            name: path
            for name, path in list(inside.items())[:MOST_FILES]
            if not any(part.startswith(".") for part in name.split("/"))
        }

    @functools.cached_property
    def robot(self) -> Robot | None:
        """The fitted robot; None where the folder has none."""
        if (self.folder / PARAMETERS).is_file():
            return read_parameters(self.folder / PARAMETERS).robot
        if self.tuning is not None and self.tuning.robots:
            return self.tuning.robot_at().robot
        return None

    @functools.cached_property
    def tuning(self) -> Tuning | None:
        """Gains and shapers; None where the folder has none."""
        path = self.folder / TUNING
        return read_tuning(path) if path.is_file() else None

    @functools.cached_property
    def runs(
        self,
    ) -> dict[str, tuple[Float[np.ndarray, " rows"], Float[np.ndarray, "rows 5"]]]:
        """Times and simulated positions of the runs by their names; empty without."""
        path = self.folder / RUNS
        return read_runs(path) if path.is_file() else {}


def open_results(folder: pathlib.Path) -> Results:
    """A folder of results.

    Args:
        folder: The folder.

    Returns:
        What it holds; what it holds wrongly is told here.

    Raises:
        ValueError: If it is no folder, has no result, or one that can't be read.
    """
    results = Results(folder)
    if not folder.is_dir():
        raise ValueError(
            f"{folder}: no such folder, got a place without results, expected what "
            "`scdpr calibrate CAMPAIGN --out DIR` has written. Name its DIR."
        )
    if not any((folder / name).is_file() for name in (REPORT, PARAMETERS, TUNING)):
        raise ValueError(
            f"{folder}: has no results, got none of {REPORT}, {PARAMETERS} and {TUNING}, "
            "expected one at least. Run `scdpr calibrate CAMPAIGN --out DIR`, and name its DIR."
        )
    # Read now, so that a broken file is told in the terminal and not on a page.
    _ = (results.tuning, results.robot, results.runs)
    return results
