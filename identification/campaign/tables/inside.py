"""Whether a campaign's files are its own: a folder may have come from anybody.

A link can lead to any file of whoever reads the campaign, whose first line a message would
show; one that leads nowhere would pass for a stream that wasn't logged.
"""

import os
from collections.abc import Iterable, Iterator
from pathlib import Path

from identification.campaign.faults import Fault


def foreign(folder: Path, names: Iterable[str]) -> Iterator[Fault]:
    """What is wrong with a run's name, and with links among its files.

    Args:
        folder: The run's folder, in the campaign's.
        names: Files that it may have.

    Yields:
        A fault for the name, for the folder and for each file.
    """
    if not folder.name.isprintable():
        yield Fault(
            what="the run's name can't be shown",
            file=folder.name,
            got="control characters, marks of direction, or what isn't UTF-8",
            expected="a name of letters, digits and signs",
            remedy='Rename the folder, like "0001-torque-step".',
        )
    yield from linked(folder, folder.parent, folder.name)
    for name in names:
        yield from linked(folder / name, folder.parent, f"{folder.name}/{name}")


def linked(path: Path, campaign: Path, file: str) -> Iterator[Fault]:
    """What is wrong with a file that is a symbolic link.

    Args:
        path: The file.
        campaign: The campaign's folder.
        file: The file, relative to that folder.

    Yields:
        A fault where the link leads out of the campaign, or nowhere.
    """
    if not path.is_symlink():
        return
    end = os.path.realpath(path)
    if not Path(end).is_relative_to(os.path.realpath(campaign)):
        got = "a link that leads out of the campaign"
    elif not os.path.exists(end):
        got = "a link that leads nowhere"
    else:
        return
    yield Fault(
        what="a symbolic link",
        file=file,
        got=got,
        expected="a file of the campaign's own",
        remedy="Copy what it leads to into the campaign, or delete the link.",
    )
