"""The folder of a tuning's exports."""

import json
import pathlib

from scdpr_jax.numerics.files import write_whole
from tuning.export import c_header, labview, matlab
from tuning.export.description import describe
from tuning.export.onboard.files import FOLDER, onboard_files
from tuning.export.onboard.program import OnBoard
from tuning.result.tuning import Tuning

PROVENANCE_FILE = "provenance.json"
"""Name of the file that tells where the others come from."""
FORMATS = (
    (c_header.FILE, c_header.c_header),
    (labview.CONTROLLER_FILE, labview.controller_table),
    (labview.SHAPERS_FILE, labview.shapers_table),
    (matlab.FILE, matlab.matlab_script),
)
"""Every exported file and what makes its text."""


def write_exports(folder: pathlib.Path, tuning: Tuning) -> tuple[pathlib.Path, ...]:
    """Write a tuning in every format, each file whole or not at all.

    Args:
        folder: Where; made if it is missing, its files of these names replaced.
        tuning: The tuning.

    Returns:
        The files.

    Raises:
        ValueError: If the tuning has no fitted robot, or no shaper, or the regions of its
            shapers at a setting aren't a grid.
    """
    description = describe(tuning)
    # Every text is made before the first is written.
    texts = {folder / name: text(description) for name, text in FORMATS}
    # A table of numbers has no room for it.
    told = json.dumps(tuning.provenance.model_dump(), indent=1, ensure_ascii=False)
    texts[folder / PROVENANCE_FILE] = told + "\n"
    fitted = tuning.robot_at()
    planner = OnBoard(fitted.robot, tuning.controller, tuning.caution)
    own = {folder / FOLDER / name: text for name, text in onboard_files(planner).items()}
    for path, text in {**texts, **own}.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, text)
    return (*texts, *own)
