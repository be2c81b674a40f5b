"""`scdpr shape`: the shaper for a measured spectrum."""

import pathlib
from typing import TYPE_CHECKING, Literal

from experiments.runtime import set_up, shown_progress
from experiments.verbs.console import ERRORS, OUT, Folder, open_call, suggest, wrote
from experiments.verbs.exit_status import DONE, FELL_SHORT
from experiments.verbs.places import try_out

if TYPE_CHECKING:
    from tuning.shapers.spectrum_file import SpectrumFile


def shape(
    spectrum: Folder,
    /,
    out: pathlib.Path,
    max_duration: str | None = None,
    max_vibration: str | None = None,
    impulses: int = 8,
    damping_ratio: float = 0.1,
    column: tuple[str, ...] = (),
    normalised: bool | None = None,
    lowest: str = "0 Hz",
    firmware: Literal["klipper", "marlin"] | None = None,
    axis: Literal["x", "y"] | None = None,
) -> int:
    """Design the shaper for a measured spectrum, beside every shaper of the catalogue.

    Args:
        spectrum: CSV file with a column freq [Hz] and densities such as psd_xyz, or one for
            each of several sensors, the worst of which counts. A raw recording, with a column
            of time and accelerations, is made a spectrum by Welch's method.
        out: Folder for shaper.json and shaper.html.
        max_duration: The longest that the shaper may be, "20 ms": the one that leaves least.
        max_vibration: The most that it may leave, "1 %": the shortest that does.
        impulses: The most impulses that a design may have; it has as few as leave hardly more.
        damping_ratio: Damping ratio that the catalogue's shapers are designed for; all are
            judged at three quarters, once and one and a half times that.
        column: Column of the densities, again for each further sensor; default: each
            sensor's total psd_xyz, else the sum of its axes.
        normalised: Whether the densities are divided by the frequency already; default:
            they are if the header has columns of shapers, such as mzv(48.4).
        lowest: Frequencies below this are left out.
        firmware: What is to run it: the design has no more impulses than that makes; default:
            any, and the lines for each are printed.
        axis: The axis that the lines are for; default: as the file's name says, else x.
    """
    try_out(out / "shaper.json")
    set_up()
    from experiments.reports import shaper_report
    from identification.campaign.quantities import parse_quantity
    from scdpr_jax.numerics.files import write_whole
    from scdpr_jax.provenance import hash_of, made_today
    from tuning.export.firmware import IMPULSES, pasted
    from tuning.shapers.shaper_file import shaper_document
    from tuning.shapers.spectrum_design import design_for_spectrum

    longest = _positive(max_duration, unit="s", name="--max-duration")
    most = _positive(max_vibration, unit="1", name="--max-vibration")
    if not 0 < damping_ratio < 0.2:
        raise ValueError(
            f"`--damping-ratio`: got {damping_ratio:g}, expected a ratio above 0 and below "
            "0.2 [1]. Machines have 0.02 to 0.15; leave it out if it isn't known."
        )
    if impulses < 2:
        raise ValueError(
            f"`--impulses`: got {impulses}, expected 2 or more: one impulse is no shaper. "
            "Leave it out for as few as leave hardly more."
        )
    impulses = impulses if firmware is None else min(impulses, IMPULSES[firmware])
    least = parse_quantity(lowest, unit="Hz", name="--lowest")
    file = _read(spectrum, column, normalised, least)
    with shown_progress(ERRORS, "shape") as progress:
        designed = design_for_spectrum(
            file.spectrum,
            damping_ratio=damping_ratio,
            damping_ratios=tuple(share * damping_ratio for share in (0.75, 1.0, 1.5)),
            max_duration=longest,
            max_vibration=most,
            impulses=impulses,
            progress=progress,
        )
    result, report = out / "shaper.json", out / "shaper.html"
    every = pasted(
        [one.fit for one in designed.compared],
        axis=axis or ("y" if "_y" in spectrum.stem.lower() else "x"),
        damping_ratio=damping_ratio,
    )
    lines = [each for each in every if firmware in (None, each.firmware.lower())]
    told = {each.firmware.lower(): each.document for each in lines}
    made = made_today(spectrum.name, hash_of([spectrum], spectrum.parent))
    write_whole(result, shaper_document(file, designed, firmware=told, provenance=made))
    write_whole(report, shaper_report.shaper_page(file, designed))
    shaper_report.show(OUT, file, designed)
    shaper_report.show_pasted(OUT, lines)
    wrote(result, report)
    suggest(open_call(report))
    short = most is not None and designed.recommended.residual > most
    return FELL_SHORT if short else DONE


def _read(
    spectrum: pathlib.Path, column: tuple[str, ...], normalised: bool | None, least: float
) -> "SpectrumFile":
    """A spectrum, or that of a recording."""
    from identification.bring.acceleration import read_acceleration
    from tuning.shapers.recording import spectrum_of_recording
    from tuning.shapers.spectrum_file import read_spectrum

    recording = None if column else read_acceleration(spectrum)
    if recording is None:
        return read_spectrum(
            spectrum, column=column or None, normalised=normalised, lowest=least
        )
    return spectrum_of_recording(
        spectrum,
        recording.time,
        recording.axes,
        told=recording.notes,
        normalised=bool(normalised),
        lowest=least,
    )


def _positive(text: str | None, *, unit: str, name: str) -> float | None:
    from identification.campaign.quantities import parse_quantity

    if text is None:
        return None
    if unit == "s" and _is_number(text):
        raise ValueError(
            f"`{name}`: a number without its unit, got {text!r}, expected a time [s]. Write it "
            f'like "{text} ms" or "{float(text) / 1e3:g} s".'
        )
    value = parse_quantity(text, unit=unit, name=name)
    if not value > 0:
        raise ValueError(
            f"`{name}`: got {text}, expected more than nothing [{unit}]. Leave it out for the "
            "recommended shaper."
        )
    return value


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
