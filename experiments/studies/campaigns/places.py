"""Which campaigns a call names, each with a name of its own."""

import pathlib
from collections.abc import Sequence
from typing import NamedTuple

from identification.campaign.read import CAMPAIGN_FILE
from scdpr_jax.numerics.files.harmless import printable

TABLES = ("campaigns.csv", "campaigns.nc")
"""What the results are put together in; no campaign can be called so."""


class Place(NamedTuple):
    """A campaign of several."""

    name: str
    """Name of its folder, which its results go by."""
    folder: pathlib.Path
    """The folder."""


def is_one(paths: Sequence[pathlib.Path]) -> bool:
    """Whether a call names a single campaign, and no folder of them.

    Args:
        paths: What it names.

    Returns:
        Whether it is one.
    """
    return len(paths) == 1 and not _inside(paths[0])


def places(paths: Sequence[pathlib.Path]) -> tuple[Place, ...]:
    """The campaigns that a call names, those of a folder in their names' order.

    Args:
        paths: Campaigns, and folders of them.

    Returns:
        The campaigns; what is neither is among them, to fail with its reason.

    Raises:
        ValueError: If two have the same name, or one can't have its own.
    """
    folders = [each for path in paths for each in (_inside(path) or [path])]
    found = [Place(folder.resolve().name, folder) for folder in folders]
    by_name: dict[str, pathlib.Path] = {}
    for name, folder in found:
        if name in by_name:
            raise ValueError(
                f"two campaigns have one name, got {printable(str(by_name[name]))} and "
                f"{printable(str(folder))}, expected a name for each: results are written to a "
                "folder of that name. Rename one, or make two calls."
            )
        if name in TABLES or name.startswith(".") or not name:
            raise ValueError(
                f"a campaign can't be called so, got {printable(str(folder))}, expected a name "
                f"that doesn't begin with a point and isn't {' or '.join(TABLES)}. Rename it."
            )
        by_name[name] = folder
    return tuple(found)


def _inside(path: pathlib.Path) -> list[pathlib.Path]:
    """The campaigns of a folder of them; none where it isn't one."""
    if not path.is_dir() or (path / CAMPAIGN_FILE).exists():
        return []
    return sorted(each for each in path.iterdir() if (each / CAMPAIGN_FILE).is_file())
