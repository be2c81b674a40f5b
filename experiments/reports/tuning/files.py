"""The files of a tuning, each by its name."""

import dataclasses
import pathlib

from tuning.export import write_exports
from tuning.result.document import write_tuning
from tuning.result.tuning import Tuning


@dataclasses.dataclass(frozen=True)
class TuningFiles:
    """Where a tuning was written."""

    tuning: pathlib.Path
    """The tuning, `tuning.json`."""
    exports: tuple[pathlib.Path, ...]
    """The same as other programs run it."""

    @property
    def paths(self) -> tuple[pathlib.Path, ...]:
        """All of them, `tuning.json` first."""
        return (self.tuning, *self.exports)


def write_tuned(out: pathlib.Path, tuning: Tuning) -> TuningFiles:
    """Write `tuning.json`, and beside it the tuning as other programs run it.

    Args:
        out: The folder; the other programs' files go into its `export`.
        tuning: The tuning.

    Returns:
        The files.

    Raises:
        ValueError: If the tuning has no fitted robot, or no shaper.
    """
    document = out / "tuning.json"
    write_tuning(document, tuning)
    return TuningFiles(document, tuple(write_exports(out / "export", tuning)))
