"""`scdpr refine`: a tuning corrected by legs that were logged."""

import dataclasses
import pathlib
from typing import TYPE_CHECKING

from experiments.runtime import set_up
from experiments.verbs.console import OUT, Folder, plan_call, say, suggest, wrote
from experiments.verbs.exit_status import DONE, FELL_SHORT
from experiments.verbs.places import try_out

if TYPE_CHECKING:
    from experiments.page.table import Table
    from tuning.refinement.refine import Refined
    from tuning.result.tuning import Tuning

EXPLAINED = 1.1
"""Misfit up to which a leg is explained down to the camera's noise [1]."""


def refine(
    tuning: Folder,
    /,
    run: tuple[pathlib.Path, ...],
    out: pathlib.Path,
) -> int:
    """Correct the robot that legs are planned for by legs that were logged.

    A planned leg that was logged, or any other run from rest to rest with drive.csv and
    camera.csv, is a measurement of what the fit gets wrong on this rig: tension, friction of
    both carriages, the loop's elasticity, the drives' gain. The fit is the prior. Where a
    correction doesn't foretell the legs left out better than the fit does, nothing is written,
    and the exit status is 1.

    Args:
        tuning: tuning.json of `scdpr tune`, `scdpr calibrate`, or of an earlier refinement.
        run: Folders of the logged legs, all at one pretension; three are usual.
        out: Folder for the corrected tuning.json and its folder export.
    """
    try_out(out / "tuning.json")
    set_up()
    from experiments.page.console_text import print_table
    from experiments.reports.tuning.files import write_tuned
    from experiments.studies.legs.logged_legs import logged_legs, read_runs
    from tuning.refinement.refine import refine as corrected
    from tuning.result.document import read_tuning

    tuned = read_tuning(tuning)
    runs, sensors = read_runs(run)
    fitted = tuned.robot_at(runs[0].pretension)
    found = corrected(fitted.robot, logged_legs(fitted.robot, runs, sensors))
    for table in (_corrected(found), _legs(found)):
        print_table(OUT, table)
        OUT.print()
    if not found.helps:
        told = all(own.before < EXPLAINED for own in found.legs)
        say(
            f"{tuning} stays as it is: "
            + (
                "the fit explains these legs down to the camera's noise."
                if told
                else "what these legs tell doesn't foretell the ones left out better than the "
                "fit does. Log legs elsewhere in the workspace."
            )
        )
        return FELL_SHORT
    written = write_tuned(out, _with(tuned, fitted.pretension, found))
    wrote(*written.paths)
    suggest(plan_call(written.tuning))
    return DONE


def _with(tuned: "Tuning", pretension: float, found: "Refined") -> "Tuning":
    """A tuning with the corrected robot at a setting, and a note of what was corrected."""
    robots = tuple(
        dataclasses.replace(own, robot=found.robot) if own.pretension == pretension else own
        for own in tuned.robots
    )
    changes = ", ".join(
        f"{own.name} {own.before:.4g} to {own.after:.4g} {own.unit}".removesuffix(" 1")
        for own in found.corrected
        if abs(own.after - own.before) > own.sigma
    )
    legs = ", ".join(own.name for own in found.legs)
    note = (
        f"The robot at {pretension:g} N is corrected by the logged legs {legs}: "
        f"{changes or 'nothing by more than its standard deviation'}. Gains, shapers and what "
        "is predicted of them are as before."
    )
    return dataclasses.replace(tuned, robots=robots, notes=(*tuned.notes, note))


def _corrected(found: "Refined") -> "Table":
    from experiments.page.number_text import readable_unit, rounded
    from experiments.page.table import Table

    rows = tuple(
        (
            f"{own.name} [{readable_unit(own.unit)}]",
            rounded(own.before, own.sigma),
            rounded(own.after, own.sigma),
            rounded(own.sigma, own.sigma),
        )
        for own in found.corrected
    )
    return Table("The robot", ("quantity", "fitted", "corrected", "± σ"), rows)


def _legs(found: "Refined") -> "Table":
    """How far robots are from the legs, in the camera's noise."""
    from experiments.page.number_text import plain
    from experiments.page.table import Table

    rows = tuple(
        (own.name, *(plain(each) for each in (own.before, own.after, own.foretold)))
        for own in found.legs
    )
    header = ("leg", "fitted", "corrected", "by the others")
    return Table("Camera less model, over the camera's noise, rms", header, rows)
