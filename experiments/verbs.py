"""What each verb of the command line does; see `experiments.cli.VERBS`."""

import pathlib
from typing import Annotated

import tyro
from rich.console import Console

from experiments.cli import BAD_INPUT, DONE, FELL_SHORT
from experiments.places import require_outside
from experiments.runtime import set_up, shown_progress, stage

Folder = Annotated[pathlib.Path, tyro.conf.Positional]

OUT = Console(highlight=False, width=max(140, Console().width))
"""Wide enough for the tables: a narrow terminal wraps them, and nothing is cut."""

ERRORS = Console(stderr=True, highlight=False)


def demo(out: pathlib.Path = pathlib.Path("demo"), seed: int = 1) -> int:
    """Generate a campaign of a robot whose truth is known, and calibrate it.

    Args:
        out: Folder for the campaign and the results.
        seed: Seed of the robot, its start poses and its noise.
    """
    set_up()
    from experiments import rig, summary
    from experiments.pipeline import calibrate, write_calibration
    from identification.campaign import read_campaign, write_campaign
    from tuning.optimise import LEG_TIMES, Effort

    logs = out / "campaign"
    if logs.exists():
        raise ValueError(
            f"`--out`: {logs} exists already, got a demo's folder or yours, expected none. "
            "Name another folder, or remove it."
        )
    with shown_progress(ERRORS) as progress:
        truth = rig.draw_truth(seed)
        made = rig.campaign(truth, seed, progress=stage(progress, 0.0, 0.2))
        out.mkdir(parents=True, exist_ok=True)
        write_campaign(made.with_runs(rig.DEMONSTRATED), logs)
        # One leg time and no descent: a demonstration has to be quick.
        calibration = calibrate(
            read_campaign(logs),
            leg_times=LEG_TIMES[:1],
            effort=Effort(descents=0),
            progress=stage(progress, 0.2, 0.95),
        )
        progress("report", 0.95)
        written = write_calibration(calibration, out, truth=truth.values)
    summary.show(
        OUT,
        calibration.estimate,
        campaign=calibration.campaign,
        frequencies=calibration.frequencies,
        truth=truth.values,
        tuning=calibration.tuning,
    )
    _wrote(logs, *written)
    _next(
        f"open {written[0]}", f"scdpr check {logs}", "scdpr calibrate YOUR-CAMPAIGN --out DIR"
    )
    return DONE if summary.covers(calibration.estimate, truth.values) else FELL_SHORT


def calibrate(
    campaign: Folder,
    /,
    out: pathlib.Path,
    skip_bad_runs: bool = False,
    free: tuple[str, ...] = (),
    hold_out: tuple[str, ...] | None = None,
) -> int:
    """Check a campaign, identify the robot, map its frequencies, tune it, and report.

    Args:
        campaign: Folder of the campaign, format 1.
        out: Folder for parameters.json, frequencies.csv, tuning.json and report.html.
        skip_bad_runs: Go on without runs that have faults, and say which.
        free: Quantities to estimate; default: friction, drive inertia and damping, and
            the effective pretension of each setting; the drives' dry friction too where
            the residuals ask for it.
        hold_out: Runs to predict instead of fitting them; default: the manoeuvre that
            goes the furthest. Give it without a name to fit every run.
    """
    set_up()
    from experiments import pipeline, summary
    from identification.campaign import read_campaign

    require_outside(out, campaign)
    read = read_campaign(campaign, skip_bad_runs=skip_bad_runs)
    with shown_progress(ERRORS) as progress:
        calibration = pipeline.calibrate(
            read,
            free=free or None,
            hold_out=hold_out,
            progress=stage(progress, 0.0, 0.93),
        )
        progress("report", 0.93)
        written = pipeline.write_calibration(calibration, out)
    summary.show(
        OUT,
        calibration.estimate,
        campaign=calibration.campaign,
        frequencies=calibration.frequencies,
        tuning=calibration.tuning,
    )
    for note in calibration.notes:
        OUT.print(f"note: {note}")
    _wrote(*written)
    _next(f"open {written[0]}", f"scdpr simulate --parameters {written[1]} --out DIR")
    return DONE


def check(campaign: Folder, /) -> int:
    """Look through a campaign's logs: every fault with file, row, cause and remedy.

    Args:
        campaign: Folder of the campaign, format 1.
    """
    from rich.table import Table

    from identification.campaign import CampaignError, check_campaign

    found = check_campaign(campaign)
    table = Table("run", "kind", "pretension", "duration", "rows", "frames", box=None)
    for run in found.runs:
        numbers = (run.pretension, run.duration, run.rows, run.camera_rows)
        force, duration, rows, frames = ("–" if n is None else f"{n:g}" for n in numbers)
        table.add_row(run.name, run.kind or "–", f"{force} N", f"{duration} s", rows, frames)
    OUT.print(table)
    for note in found.notes:
        OUT.print(f"note: {note}", markup=False)
    if found.faults:
        print(f"scdpr check: {CampaignError(campaign, found.faults)}", file=ERRORS.file)
        return BAD_INPUT
    OUT.print(f"{len(found.runs)} runs, no fault.")
    _next(f"scdpr calibrate {campaign} --out DIR")
    return DONE


def identify(
    campaign: Folder,
    /,
    out: pathlib.Path,
    skip_bad_runs: bool = False,
    free: tuple[str, ...] = (),
    hold_out: tuple[str, ...] = (),
) -> int:
    """Estimate the robot's parameters from all runs of a campaign.

    Args:
        campaign: Folder of the campaign, format 1.
        out: Folder for parameters.json.
        skip_bad_runs: Go on without runs that have faults, and say which.
        free: Quantities to estimate; default: friction, drive inertia and damping, and
            the effective pretension of each setting.
        hold_out: Runs to predict instead of fitting them.
    """
    set_up()
    from experiments import summary
    from experiments.parameters_file import write_parameters
    from identification.campaign import read_campaign
    from identification.estimate import estimate
    from identification.unknowns import DEFAULT_FREE

    require_outside(out, campaign)
    read = read_campaign(campaign, skip_bad_runs=skip_bad_runs)
    with shown_progress(ERRORS) as progress:
        found = estimate(read, free=free or DEFAULT_FREE, hold_out=hold_out, progress=progress)
    write_parameters(out / "parameters.json", found)
    summary.show(OUT, found, campaign=read)
    _wrote(out / "parameters.json")
    _next(f"scdpr frequencies {campaign} --out {out}")
    return DONE


def identify_drive(log: Folder, /, gain: str, out: pathlib.Path, delay_samples: int = 0) -> int:
    """Estimate one motor-driven axis from a log of voltage and position.

    Args:
        log: CSV file with the columns t, voltage and position, units in the header.
        gain: Force of the drive per volt, with its unit: "35.1507 N/V".
        out: Folder for parameters.json and report.html.
        delay_samples: Samples by which the logged voltage acts late.
    """
    set_up()
    from experiments import report, summary
    from experiments.parameters_file import write_axis_parameters
    from identification.axis_log import read_axis_log
    from identification.drive_axis import estimate_drive_axis
    from identification.quantities import parse_quantity

    force = parse_quantity(gain, unit="N/V", name="--gain")
    read = read_axis_log(log)
    with ERRORS.status("open-loop fits from several starts, some ten seconds"):
        found = estimate_drive_axis(read, gain=force, delay_samples=delay_samples)
    write_axis_parameters(out / "parameters.json", found)
    report.write_drive_report(out / "report.html", log=read, estimate=found)
    summary.show_axis(OUT, found, position_unit=read.position_unit)
    _wrote(out / "parameters.json", out / "report.html")
    return DONE if found.converged else FELL_SHORT


def frequencies(campaign: Folder, /, out: pathlib.Path, skip_bad_runs: bool = False) -> int:
    """Find natural frequency and damping of every knock.

    Args:
        campaign: Folder of the campaign, format 1.
        out: Folder for frequencies.csv.
        skip_bad_runs: Go on without runs that have faults, and say which.
    """
    from experiments import summary
    from identification.campaign import read_campaign
    from identification.frequency_map import frequency_map, write_frequencies

    require_outside(out, campaign)
    found = frequency_map(read_campaign(campaign, skip_bad_runs=skip_bad_runs))
    write_frequencies(found, out / "frequencies.csv")
    summary.show_frequencies(OUT, found)
    _wrote(out / "frequencies.csv")
    _next(f"scdpr tune --parameters P --frequencies {out / 'frequencies.csv'} --out {out}")
    return DONE


def tune(parameters: pathlib.Path, frequencies: pathlib.Path, out: pathlib.Path) -> int:
    """Design gains and a shaper for each region of the workspace.

    Args:
        parameters: parameters.json of `scdpr identify`.
        frequencies: frequencies.csv of `scdpr frequencies`.
        out: Folder for tuning.json.
    """
    set_up()
    from experiments import summary
    from experiments.parameters_file import read_parameters
    from identification.frequency_map import read_frequencies
    from tuning.document import write_tuning
    from tuning.tune import tune as design

    fitted = read_parameters(parameters)
    measured = read_frequencies(frequencies)
    with shown_progress(ERRORS) as progress:
        tuned = design(fitted, measured, progress=progress)
    write_tuning(out / "tuning.json", tuned)
    summary.show_tuning(OUT, tuned)
    _wrote(out / "tuning.json")
    _next(f"scdpr simulate --parameters {parameters} --tuning {out / 'tuning.json'} --out DIR")
    return DONE


def simulate(
    parameters: pathlib.Path,
    out: pathlib.Path,
    manoeuvre: str = "horizontal",
    leg_time: str = "2 s",
    setting: str | None = None,
    tuning: pathlib.Path | None = None,
) -> int:
    """Simulate a manoeuvre of Table 3 with a fitted robot.

    Args:
        parameters: parameters.json of `scdpr identify` or `scdpr calibrate`.
        out: Folder for simulation.csv.
        manoeuvre: horizontal, vertical or diagonal.
        leg_time: Time of one leg, with its unit.
        setting: Nominal pretension, "350 N"; default: the first of the parameters.
        tuning: tuning.json for its gains and shaper; default: the PD of Eq. (25) alone.
    """
    set_up()
    import numpy as np

    from experiments import simulated_run
    from experiments.parameters_file import read_parameters
    from identification.quantities import parse_quantity
    from scdpr_jax.files import write_whole
    from tuning.document import read_tuning

    fitted = read_parameters(parameters)
    label = setting or (fitted.settings[0] if fitted.settings else "0 N")
    pretension = parse_quantity(label, unit="N", name="--setting")
    leg = parse_quantity(leg_time, unit="s", name="--leg-time")
    reference = simulated_run.manoeuvre(manoeuvre, leg)
    tuned = None if tuning is None else read_tuning(tuning)
    with ERRORS.status("simulating"):
        run, commanded = simulated_run.simulate(
            fitted.of_setting(label), reference, tuned, pretension
        )
    write_whole(out / "simulation.csv", simulated_run.table(run, commanded))
    x = np.asarray(run.states.position)[:, 0]
    rested = np.asarray(run.time) >= float(run.time[-1]) - simulated_run.HOLD
    pose = np.asarray(run.states.position)[:, [0, 4]]
    error = np.hypot(*(commanded - pose).T)
    OUT.print(
        f"Largest error, Eq. (26): {1e3 * error.max():.1f} mm. Vibration after the arrival: "
        f"{1e3 * np.ptp(x[rested]):.2f} mm peak to peak. Largest command: "
        f"{np.abs(np.asarray(run.voltage)).max():.2f} V."
    )
    _wrote(out / "simulation.csv")
    return DONE


def _wrote(*paths: pathlib.Path) -> None:
    OUT.print()
    for path in paths:
        OUT.print(f"wrote {path}", markup=False)


def _next(*calls: str) -> None:
    for call in calls:
        OUT.print(f"next: {call}", markup=False)
