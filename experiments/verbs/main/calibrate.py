"""`scdpr calibrate`: from a campaign to parameters, frequencies, gains and shapers."""

import pathlib

from experiments.runtime import processes_aside, set_up, shown_progress
from experiments.verbs.console import (
    ERRORS,
    OUT,
    Folder,
    open_call,
    pasted,
    plan_call,
    say,
    suggest,
    wrote,
)
from experiments.verbs.exit_status import BAD_INPUT, DONE, FELL_SHORT
from experiments.verbs.places import require_outside, try_out


def calibrate(
    campaign: Folder,
    /,
    out: pathlib.Path,
    skip_bad_runs: bool = False,
    free: tuple[str, ...] = (),
    hold_out: tuple[str, ...] | None = None,
    measured: tuple[str, ...] = (),
    camera_drifts: bool = False,
    accept: tuple[str, ...] = (),
    force: bool = False,
) -> int:
    """Check a campaign, identify the robot, map its frequencies, tune it, and report.

    Args:
        campaign: Folder of the campaign, format 1.
        out: Folder for parameters.json, frequencies.csv, tuning.json, report.html and, in
            its folder export, the tuning in C, for LabVIEW and for MATLAB.
        skip_bad_runs: Go on without runs that have faults, and say which.
        free: Quantities to estimate; default: friction, drive inertia and damping, and
            the effective pretension of each setting, and where these leave more than noise
            those of the model that explains the rest best.
        hold_out: Runs to predict instead of fitting them; default: the manoeuvre that
            goes the furthest. Give it without a name to fit every run.
        measured: What was measured otherwise, "NAME = VALUE +- STANDARD ERROR [at PLACE]",
            see `scdpr identify --help`.
        camera_drifts: Whether the cameras' clocks may run faster or slower than the drives'.
        accept: Contradictions of the log doctor to go on with, by their identifiers; the
            report and parameters.json carry them.
        force: Make gains and shapers from a fit that has failed, too; every file is marked.
    """
    # What is wrong with the input is said before anything heavy is imported.
    from experiments.verbs.log_doctor import examined
    from identification.campaign import read_campaign
    from identification.campaign.abbreviation import free_quantities, run_names

    require_outside(out, campaign)
    try_out(out / "report.html")
    logs = read_campaign(campaign, skip_bad_runs=skip_bad_runs)
    held_out = None if hold_out is None else run_names(logs, hold_out)
    freed = free_quantities(free)
    read = examined(logs, accept, verb="calibrate")
    if read is None:
        return BAD_INPUT
    with processes_aside() as processes:
        set_up()
        from experiments.page.pictures.drawing import draws_by
        from experiments.reports import summary
        from experiments.reports.report import FitPictures
        from experiments.reports.written_files import write_calibration
        from experiments.studies import pipeline
        from identification.fit.unknowns.measured_text import parse_measured

        otherwise = tuple(map(parse_measured, measured))
        pictures = FitPictures(read, draw=draws_by(processes))
        with shown_progress(ERRORS, "calibrate", campaign) as progress:
            findings = pipeline.calibrate(
                read,
                free=freed or None,
                hold_out=held_out,
                measured=otherwise,
                clock_drifts=camera_drifts,
                force=force,
                fitted=pictures.begin,
                processes=processes,
                progress=progress.part(0.0, 0.93),
            )
            written = write_calibration(
                findings, out, pictures=pictures, progress=progress.part(0.93, 1.0)
            )
    summary.show(OUT, findings)
    for note in findings.notes:
        say(f"note: {note}")
    wrote(*written.paths)
    suggest(open_call(written.report))
    if not findings.estimate.fits:
        suggest(f"scdpr check {pasted(campaign)}")
        return FELL_SHORT
    suggest(
        f"scdpr simulate --parameters {pasted(written.parameters)} --out {pasted(out)}",
        plan_call(out / "tuning.json"),
    )
    return DONE
