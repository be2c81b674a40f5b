"""`scdpr design`: which experiment next."""

import pathlib
from typing import Annotated

import tyro

from experiments.cli import DONE
from experiments.runtime import set_up, shown_progress, stage
from experiments.verbs.console import ERRORS, OUT, Folder, suggest, wrote


def design(
    known: Folder,
    /,
    wanted: Annotated[str, tyro.conf.arg(name="for")],
    out: pathlib.Path,
    setting: str | None = None,
    duration: str = "2 s",
    top_speed: str = "1.5 m/s",
) -> int:
    """Design the run that shrinks a standard error the most per second of rig time.

    Shapes of a catalogue are compared and improved by gradient, within the drives' voltage,
    the frame and a speed, given what the earlier runs tell.

    Args:
        known: Folder of a campaign, which is fitted first, or parameters.json of
            `scdpr identify`.
        wanted: The quantity whose standard error is to shrink, "friction_coefficient", or
            "d-optimal" or "a-optimal" for all of them.
        out: The table of voltages to write, next.csv.
        setting: Nominal pretension of the run, "350 N"; default: the first one known.
        duration: Longest run.
        top_speed: Largest speed of the end-effector in either direction.
    """
    set_up()
    from experiments import next_run
    from experiments.console_text import print_lines, rich_table
    from experiments.known_rig import poses, rig_from
    from identification.excitation import catalogue
    from identification.next_experiment import propose
    from identification.quantities import parse_quantity
    from scdpr_jax.files import write_whole
    from scdpr_jax.parameters import value

    longest = parse_quantity(duration, unit="s", name="--duration")
    speed = parse_quantity(top_speed, unit="m/s", name="--top-speed")
    with shown_progress(ERRORS) as progress:
        rig, channels = rig_from(
            known,
            setting=setting,
            top_speed=speed,
            progress=stage(progress, 0.0, 0.4),
        )
        criterion = next_run.criterion_for(wanted, rig)
        excitations = catalogue(
            limit=float(value(rig.robot, "voltage_limit")),
            duration=longest,
            poses=poses(rig.robot),
        )
        found = propose(rig, excitations, criterion, progress=stage(progress, 0.4, 1.0))
    write_whole(out, next_run.voltage_table(found[0]))
    OUT.print(rich_table(next_run.candidate_table(rig, wanted, found)))
    print_lines(OUT, (*next_run.caution(channels), *next_run.instructions(found[0])))
    wrote(out)
    suggest("scdpr identify CAMPAIGN --out DIR, with the new run in its folder")
    return DONE
