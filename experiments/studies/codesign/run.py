"""A fitted robot's co-design: the robots that it is made for and judged on."""

import re

from experiments.studies.posterior import at_settings, draw
from identification.result.fitted_robot import FittedRobot
from scdpr_jax.numerics.progress import SILENT, Progress, listening
from tuning.codesign import CoDesign, Scope, recommend
from tuning.codesign.search import Designer, in_turn
from tuning.result.tuning import FittedSetting

_UNSEEN_SEED = 1000
"""Seeds of the robots that no design has seen lie so far from the others' [1]."""


def parse_grid(text: str) -> tuple[int, int]:
    """A grid as it is written.

    Args:
        text: "4x5": columns and rows.

    Returns:
        Both.

    Raises:
        ValueError: If it is no such text, or has less than one column or two rows.
    """
    match = re.fullmatch(r"\s*(\d+)\s*[x×]\s*(\d+)\s*", text)
    if match is None or int(match[1]) < 1 or int(match[2]) < 2:
        raise ValueError(
            f"`--grid`: got {text!r}, expected columns and rows of the poses that legs end at "
            '[1], such as "4x5", with two rows at the least.'
        )
    return int(match[1]), int(match[2])


def design(
    fitted: FittedRobot,
    scope: Scope,
    *,
    designer: Designer = in_turn,
    progress: Progress | bool = SILENT,
) -> CoDesign:
    """A co-design of a fitted robot.

    Args:
        fitted: The robot.
        scope: What it is to be for.
        designer: Who searches, see `experiments.studies.codesign.kept`.
        progress: Told what is being done and which share of it is done;
            True shows it in a notebook.

    Returns:
        The co-design.

    Raises:
        ValueError: If no robot is to be drawn, or the move times are too short.
    """
    progress = listening(progress)
    if scope.samples < 1:
        raise ValueError(
            f"`--samples`: got {scope.samples}, expected one robot or more [1]. 16 show what "
            "a fit leaves open."
        )
    robots = zip(scope.settings, at_settings(fitted, scope.settings), strict=True)
    few, seed = max(scope.samples // 2, 1), scope.seed + _UNSEEN_SEED
    return recommend(
        tuple(FittedSetting(setting, robot) for setting, robot in robots),
        scope,
        drawn=draw(fitted, scope.settings, count=scope.samples, seed=scope.seed),
        unseen=draw(fitted, scope.settings, count=few, seed=seed),
        designer=designer,
        progress=progress,
    )
