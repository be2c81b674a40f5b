"""`scdpr demo`: a campaign of known truth, calibrated."""

import pathlib

from experiments.runtime import processes_aside, set_up, shown_progress
from experiments.verbs.console import ERRORS, OUT, open_call, pasted, plan_call, suggest, wrote
from experiments.verbs.exit_status import DONE, FELL_SHORT
from experiments.verbs.places import try_out


def demo(out: pathlib.Path = pathlib.Path("demo"), seed: int = 1) -> int:
    """Generate a campaign of a robot whose truth is known, and calibrate it.

    Args:
        out: Folder for the campaign and the results.
        seed: Seed of the robot, its start poses and its noise.
    """
    try_out(out / "report.html")
    set_up()
    from experiments.page.pictures.drawing import draws_by
    from experiments.reports import summary
    from experiments.reports.report import FitPictures
    from experiments.reports.written_files import write_calibration
    from experiments.studies.findings.parameters import covers
    from experiments.studies.pipeline import calibrate
    from experiments.virtual_rig import rig
    from identification.campaign import read_campaign, write_campaign
    from tuning.gains.manoeuvre import LEG_TIMES
    from tuning.gains.optimise import Effort

    logs = out / "campaign"
    if logs.exists():
        raise ValueError(
            f"`--out`: {logs} exists already, got a demo's folder or yours, expected none. "
            "Name another folder, or remove it."
        )
    with shown_progress(ERRORS, "demo") as progress, processes_aside() as processes:
        truth = rig.draw_truth(seed)
        made = rig.campaign(truth, seed, progress=progress.part(0.0, 0.2))
        out.mkdir(parents=True, exist_ok=True)
        write_campaign(made.with_runs(rig.DEMONSTRATED), logs)
        read = read_campaign(logs)
        pictures = FitPictures(read, truth=truth.values, draw=draws_by(processes))
        # One leg time and half of the search: a demonstration has to be quick.
        findings = calibrate(
            read,
            leg_times=LEG_TIMES[:1],
            effort=Effort(generations=3),
            fitted=pictures.begin,
            processes=processes,
            progress=progress.part(0.2, 0.95),
        )
        written = write_calibration(
            findings,
            out,
            truth=truth.values,
            pictures=pictures,
            progress=progress.part(0.95, 1.0),
        )
    summary.show(OUT, findings, truth=truth.values)
    wrote(logs, *written.paths)
    suggest(open_call(written.report), f"scdpr check {pasted(logs)}")
    if written.tuning is not None:
        suggest(plan_call(written.tuning.tuning))
    suggest("scdpr import YOUR-LOGS --propose mapping.toml")
    return DONE if covers(findings.estimate, truth.values) else FELL_SHORT
