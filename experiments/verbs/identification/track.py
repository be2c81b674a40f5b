"""`scdpr track`: poses from a video."""

import pathlib
from typing import TYPE_CHECKING

from experiments.runtime import shown_progress
from experiments.verbs.console import ERRORS, Folder, pasted, say, suggest, wrote
from experiments.verbs.exit_status import DONE, FELL_SHORT
from experiments.verbs.places import try_out

if TYPE_CHECKING:
    from identification.vision.tracking import Tracked

_ENOUGH = 0.5


def track(
    vision: Folder,
    /,
    out: pathlib.Path | None = None,
    overlay: pathlib.Path | None = None,
    json: pathlib.Path | None = None,
    propose: pathlib.Path | None = None,
) -> int:
    """Track marks and markers in a video: camera.csv of a run.

    Args:
        vision: What is said of the video, a TOML file; with --propose the video itself.
        out: The file to write, camera.csv of a run.
        overlay: Video to write, .mp4, with what was found drawn on every picture.
        json: File to write with counts, fits and standard deviations.
        propose: TOML file to write for the video: its colours, marks and markers as they are
            found, the rest left to be filled in, and a picture with their numbers.
    """
    files = {"--out": out, "--overlay": overlay, "--json": json, "--propose": propose}
    for name, path in files.items():
        if path is not None:
            try_out(path, name=name)
    if propose is not None:
        return _propose(vision, propose)
    if out is None:
        raise ValueError(
            "`--out` is missing, expected a file like camera.csv; or --propose VISION.toml to "
            "begin with a video."
        )
    from identification.vision.camera_file import write_camera, write_summary
    from identification.vision.overlay import write_overlay
    from identification.vision.settings import read_vision
    from identification.vision.tracking import track as tracked_poses

    told = read_vision(vision)
    with shown_progress(ERRORS, "track") as progress:
        whole = progress.part(0.0, 0.6 if overlay else 1.0)
        tracked = tracked_poses(told, vision.parent, progress=whole)
        write_camera(out, tracked)
        if json is not None:
            write_summary(json, tracked)
        if overlay is not None:
            write_overlay(
                overlay, told, vision.parent, tracked, progress=progress.part(0.6, 1.0)
            )
    _show(tracked)
    _state(out, tracked)
    wrote(*(path for path in (out, json, overlay) if path is not None))
    short = tracked.posed < _ENOUGH * len(tracked.clock.frames)
    if short:
        call = (
            "see with --overlay FILE.mp4 which markers aren't found, and describe their colours"
        )
        say(f"fewer than half of the pictures have every pose: {call}")
        return FELL_SHORT
    return DONE


def _show(tracked: "Tracked") -> None:
    from identification.vision.camera_file import summary

    told = summary(tracked)
    lens = tracked.marks.view.lens.rms
    board = "lens as stated" if lens is None else f"board {lens:.3f} px"
    say(
        f"{told['frames']} pictures, {told['posed']} with every pose; "
        f"{told['dropped']} dropped, {told['doubled']} doubled; "
        f"{board}, marks {tracked.marks.rms:.3f} px (rms)",
    )
    say(
        "standard deviations: "
        + ", ".join(f"{name} {value}" for name, value in told["sigma"].items() if value),
    )
    for warning in tracked.warnings:
        say(f"note: {warning}")


def _state(out: pathlib.Path, tracked: "Tracked") -> None:
    """Put the standard deviations where a fit weighs this run's camera by them."""
    from identification.campaign.extend import state_camera
    from identification.campaign.read import CAMPAIGN_FILE
    from identification.campaign.streams import CAMERA_FILE
    from identification.campaign.types import HEIGHT_OFFSET
    from identification.campaign.write import camera_sigma_table
    from identification.vision.camera_file import rounded

    offset = {HEIGHT_OFFSET: tracked.sigma.common["y_e"]}
    sigma = rounded(tracked.sigma.columns | offset)
    run = out.resolve().parent
    if out.name == CAMERA_FILE and state_camera(run.parent, run.name, sigma):
        say(f"stated in {run.parent / CAMPAIGN_FILE}, by which a fit weighs this run's camera")
        return
    say(f"\nin {CAMPAIGN_FILE}, so that a fit weighs this run's camera as it is:")
    for line in camera_sigma_table(run.name, sigma):
        say(f"  {line}")


def _propose(video: pathlib.Path, target: pathlib.Path) -> int:
    from identification.vision.proposal import propose

    with shown_progress(ERRORS, "track --propose") as progress:
        proposal = propose(video, target, progress=progress)
    for line in proposal.lines:
        say(line)
    wrote(target, proposal.picture)
    suggest(
        f"fill in what is empty in {target}",
        f"scdpr track {pasted(target)} --out {pasted(target.with_name('camera.csv'))}",
    )
    return DONE
