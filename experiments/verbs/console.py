"""What the verbs share of the console: where they print, and how they end."""

import pathlib
from typing import TYPE_CHECKING, Annotated

import tyro
from rich.console import Console

if TYPE_CHECKING:
    from experiments.runtime.store.store import Distrusted

Folder = Annotated[pathlib.Path, tyro.conf.Positional]
"""A path that is given without a flag."""

OUT = Console(highlight=False, width=max(140, Console().width))
"""Wide enough for the tables: a narrow terminal wraps them, and nothing is cut."""

ERRORS = Console(stderr=True, highlight=False)
"""Progress and complaints."""


def wrote(*paths: pathlib.Path) -> None:
    """Say which files were written.

    Args:
        paths: The files.
    """
    OUT.print()
    for path in paths:
        OUT.print(f"wrote {path}", markup=False, soft_wrap=True)


def suggest(*calls: str) -> None:
    """Say what to do next.

    Args:
        calls: Calls to make.
    """
    for call in calls:
        # A call that is broken into lines can't be pasted.
        OUT.print(f"next: {call}", markup=False, soft_wrap=True)


def plan_call(tuning: pathlib.Path) -> str:
    """How to plan a leg with a tuning.

    Args:
        tuning: Its tuning.json.

    Returns:
        The call.
    """
    return f'scdpr plan {tuning} --from "0.3 m, 0.55 m" --to "1.9 m, 0.55 m" --out plan.csv'


def tell_distrusted(found: "Distrusted") -> None:
    """Say what isn't used of what an earlier call has left.

    Args:
        found: What it is.
    """
    text = f"{found.name}: {found.why}. It is computed anew."
    ERRORS.print(text, markup=False, soft_wrap=True)
