"""Where results may be written, and where the end-effector may go."""

import pathlib
import tempfile
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


def require_folder(out: pathlib.Path) -> None:
    """Refuse a folder for results that can't be written to, before anything is computed.

    Args:
        out: The folder; it needn't exist.

    Raises:
        ValueError: If it is a file, or can't be made or written to.
    """
    if out.exists() and not out.is_dir():
        raise ValueError(
            f"`--out`: got {out}, a file, expected a folder for the results. Name another one."
        )
    _require_writable(out)


def require_file(out: pathlib.Path, *, name: str = "--out") -> None:
    """Refuse a file for results that can't be written, before anything is computed.

    Args:
        out: The file; it is replaced if it exists.
        name: The argument that names it.

    Raises:
        ValueError: If it is a folder, or can't be written.
    """
    if out.is_dir():
        raise ValueError(
            f"`{name}`: got {out}, a folder, expected a file. Name one in it, such as "
            f"{out / 'result'}."
        )
    _require_writable(out.parent, name=name)


def _require_writable(folder: pathlib.Path, *, name: str = "--out") -> None:
    """Refuse a folder in which nothing can be made."""
    there = next(each for each in (folder, *folder.absolute().parents) if each.exists())
    if not there.is_dir():
        raise ValueError(
            f"`{name}`: got {folder}, but {there} is a file, expected a folder. Name another "
            "place."
        )
    try:
        with tempfile.TemporaryFile(dir=there):
            pass
    except OSError as error:
        raise ValueError(
            f"`{name}`: nothing can be written to {there}, got {error.strerror}, expected a "
            "folder of yours with room. Name another place."
        ) from None


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
    low = float(robot.end_effector.lower_offset)
    high = float(robot.frame.height - robot.end_effector.upper_offset)
    if not (0 <= x <= width and low < y < high):
        raise ValueError(
            f"`{name}` is outside of the frame, got x = {x:g} m, y = {y:g} m, expected x from "
            f"0 to {width:g} m and y between {low:g} and {high:g} m, where the attachments "
            "meet the guides. Name a position inside."
        )
    return x, y
