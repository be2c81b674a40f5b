"""Where results may be written, and where the end-effector may go."""

import pathlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scdpr_jax.robot.parameters import Robot


def require_outside(out: pathlib.Path, campaign: pathlib.Path) -> None:
    """Refuse to write results among the logs, where they would pass for a run.

    Args:
        out: Where results shall go.
        campaign: The campaign's folder.

    Raises:
        ValueError: If `out` is the campaign's folder or inside it.
    """
    if out.resolve().is_relative_to(campaign.resolve()):
        raise ValueError(
            f"`--out` must be outside the campaign, got {out} inside {campaign}: a folder in "
            "a campaign is a run. Name another folder."
        )


def try_out(*files: pathlib.Path, name: str = "--out") -> None:
    """Try whether results can be written, before anything is computed.

    Args:
        files: Files that will be written; their folders are made as they will be.
        name: The argument that names them.

    Raises:
        ValueError: If one of them can't be: a folder is in its place, a file in its folder's,
            its folder is closed, or its disk full.
    """
    from scdpr_jax.numerics.files.scratch import scratch_file

    for file in files:
        if file.is_dir():
            raise ValueError(
                f"`{name}`: got {file}, a folder, expected a file. Name one in it, such as "
                f"{file / 'result'}."
            )
        made = _missing(file.parent)
        try:
            file.parent.mkdir(parents=True, exist_ok=True)
            with scratch_file(file) as scratch:
                scratch.write_bytes(bytes(_ROOM))
        except OSError as error:
            barred = isinstance(error, FileExistsError | NotADirectoryError)
            got = "a file in its folder's place" if barred else error.strerror
            raise ValueError(
                f"`{name}`: {file} can't be written, got {got}, expected a folder "
                "that can be, and room on its disk. Name another one, or make room there."
            ) from None
        finally:
            for folder in made:
                _remove_empty(folder)


_ROOM = 2**16
"""Bytes that are written to see whether a disk is full."""


def _missing(folder: pathlib.Path) -> list[pathlib.Path]:
    """Folders that will have to be made, the innermost first."""
    return [each for each in (folder, *folder.parents) if not each.exists()]


def _remove_empty(folder: pathlib.Path) -> None:
    if folder.is_dir() and not any(folder.iterdir()):
        folder.rmdir()


def results_of(campaign: pathlib.Path) -> pathlib.Path:
    """A folder for a campaign's results: here, or beside the campaign from inside of it.

    Args:
        campaign: The campaign's folder.

    Returns:
        The folder's name for a call.
    """
    folder = campaign.resolve()
    beside = folder.with_name(f"{folder.name}-results")
    inside = pathlib.Path.cwd().is_relative_to(folder)
    return beside if inside else pathlib.Path(beside.name)


def parse_position(text: str, *, name: str, robot: "Robot") -> tuple[float, float]:
    """A position of the end-effector inside the frame.

    Args:
        text: Two lengths with their units, "0.3 m, 0.55 m".
        name: The argument it stands in, for the message.
        robot: The robot whose frame and attachments bound it.

    Returns:
        $[x_e, y_e]$ [m].

    Raises:
        ValueError: If it isn't two lengths, or lies outside of what the frame allows.
    """
    from identification.campaign.quantities import parse_quantity

    parts = text.split(",")
    if len(parts) != 2:
        raise ValueError(
            f"`{name}` isn't a position, got {text!r}, expected two lengths with their units "
            '[m], such as "0.3 m, 0.55 m".'
        )
    x, y = (parse_quantity(part.strip(), unit="m", name=name) for part in parts)
    width = float(robot.frame.width)
    low, high = map(float, robot.heights)
    if not (0 <= x <= width and low < y < high):
        raise ValueError(
            f"`{name}` is outside of the frame, got x = {x:g} m, y = {y:g} m, expected x from "
            f"0 to {width:g} m and y between {low:g} and {high:g} m, where the attachments "
            "meet the guides. Name a position inside."
        )
    return x, y
