"""What a report tells of gains and shapers, before and after, in tables."""

import numpy as np

from experiments.page.number_text import percent, plain, short
from experiments.page.table import Table, table_of
from experiments.studies.findings.tuning import region_name
from experiments.studies.legs.in_space import in_space
from scdpr_jax.legs.leg import Leg
from tuning.result.prediction import Metrics
from tuning.result.regional_shaper import RegionalShaper
from tuning.result.tuning import Tuning

_SPARE = (("band [Hz]",), ("kind",), ("left, nominal", "worst"), ("from",), ("left of legs",))
"""What of a shaper a narrow terminal can do without: a file and a figure have it."""


def tuning_tables(tuning: Tuning) -> tuple[Table, ...]:
    """A tuning's gains, shapers and predictions.

    Args:
        tuning: The tuning.

    Returns:
        The tables that aren't empty.
    """
    shapers = map(_shaper, tuning.shapers)
    tables = (
        _gains(tuning),
        table_of("Shapers, for legs that end in the region", shapers, spare=_SPARE),
        _legs(tuning),
        _predicted(tuning),
    )
    return tuple(table for table in tables if table.rows)


def _gains(tuning: Tuning) -> Table:
    controller, margins = tuning.controller, tuning.margins
    gain_margin = float(margins.gain_margin)
    return Table(
        "Controller of both drives",
        ("quantity", "value", "unit"),
        (
            ("proportional gain", short(float(controller.proportional_gain)), "V/rad"),
            ("derivative gain", short(float(controller.derivative_gain)), "V s/rad"),
            ("derivative filter", short(1e3 * float(controller.filter_time), 4), "ms"),
            ("sample period", short(1e3 * float(controller.period), 4), "ms"),
            ("gain crossover", short(float(margins.gain_crossover), 4), "rad/s"),
            ("phase margin", short(float(np.degrees(margins.phase_margin)), 4), "°"),
            ("delay margin", short(1e3 * float(margins.delay_margin), 4), "ms"),
            ("gain margin", short(20 * float(np.log10(gain_margin)), 4), "dB"),
            ("peak sensitivity", short(float(margins.peak_sensitivity), 4), "1"),
        ),
    )


def _shaper(regional: RegionalShaper) -> dict[str, str]:
    times = np.atleast_1d(np.asarray(regional.shaper.times))
    amplitudes = np.atleast_1d(np.asarray(regional.shaper.amplitudes))
    return {
        "region": region_name(regional),
        "frequency [Hz]": short(regional.frequency, 4),
        "band [Hz]": _band(*regional.band),
        "from": "knock" if regional.measured else "model",
        "kind": regional.kind or "–",
        "left of legs": "–" if regional.share is None else percent(regional.share),
        "times [ms]": ", ".join(plain(1e3 * float(time), 3) for time in times),
        "amplitudes [1]": ", ".join(short(float(share), 3) for share in amplitudes),
        "left, nominal": percent(regional.residual_vibration.nominal),
        "worst": percent(regional.residual_vibration.worst),
    }


def _band(low: float, high: float) -> str:
    """A band with as many digits as tell its ends apart; the model's own frequency has none."""
    for digits in range(4, 8):
        ends = short(low, digits), short(high, digits)
        if ends[0] != ends[1]:
            return "–".join(ends)
    return short(low, 4)


def _legs(tuning: Tuning) -> Table:
    """Random legs before and after, leg for leg alike."""
    title = "Random legs over the workspace, on robots as they might be"
    if tuning.legs is None:
        return table_of(title, ())
    sides = [("Eq. (25), plain", tuning.legs.before), ("gains and shapers", tuning.legs.after)]
    if tuning.legs.planned is not None:
        count = len(tuning.legs.planned.vibration)
        sides.append((f"planned, the first {count}", tuning.legs.planned))
    return table_of(
        title,
        (
            {
                "command": name,
                **{
                    f"{what} [mm], {which}": plain(1e3 * float(np.quantile(values, at)), 3)
                    for what, values in (
                        ("vibration", outcome.vibration),
                        ("resting error", outcome.resting_error),
                    )
                    for which, at in (("median", 0.5), ("nine of ten", 0.9), ("worst", 1.0))
                },
            }
            for name, outcome in sides
        ),
    )


_COMPARED = (
    ("vibration after arrival [mm]", 1e3, "residual_vibration"),
    ("resting error [mm]", 1e3, "resting_error"),
    ("largest error, commanded [mm]", 1e3, "largest_error"),
    ("largest command [V]", 1.0, "largest_voltage"),
    ("saturated [%]", 100.0, "saturation"),
)


def _predicted(tuning: Tuning) -> Table:
    return table_of(
        "Manoeuvres, simulated before and after",
        (
            {"manoeuvre": f"{manoeuvre.name}, {side}", **_metrics(metrics), **_space(run)}
            for manoeuvre in tuning.predicted
            for side, metrics, run in (
                ("before", manoeuvre.before, manoeuvre.run_before),
                ("after", manoeuvre.after, manoeuvre.run_after),
            )
        ),
    )


def _metrics(metrics: Metrics) -> dict[str, str]:
    return {name: plain(f * getattr(metrics, field), 3) for name, f, field in _COMPARED}


def _space(run: Leg | None) -> dict[str, str]:
    """How far a run is behind its unshaped reference, and what is off besides."""
    placed = None if run is None else in_space(run)
    return {
        "behind the reference [s]": "–" if placed is None else plain(placed.lag),
        "largest error, lag taken off [mm]": (
            "–" if placed is None else plain(1e3 * float(placed.distance.max()), 3)
        ),
    }
