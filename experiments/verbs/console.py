"""What the verbs share of the console: where they print, and how they end."""

import os
import pathlib
import shlex
import subprocess
import sys
from typing import Annotated

import tyro
from rich.console import Console

from experiments.page.console_text import print_text

Folder = Annotated[pathlib.Path, tyro.conf.Positional]
"""A path that is given without a flag."""

_UNBOUNDED = 100_000


def _width(is_terminal: bool) -> int | None:
    """Columns to print in, None for those of the terminal."""
    return None if os.environ.get("COLUMNS") or is_terminal else _UNBOUNDED


OUT = Console(highlight=False, width=_width(sys.stdout.isatty()))
"""As wide as the terminal. A file or a pipe has no width: there a sentence is one line."""

ERRORS = Console(stderr=True, highlight=False, width=_width(sys.stderr.isatty()))
"""Progress and complaints."""


def say(text: str, *, style: str = "") -> None:
    """Print a text, its words whole.

    Args:
        text: The text.
        style: How it is set.
    """
    print_text(OUT, text, style=style)


def complain(text: str) -> None:
    """Print what is wrong, its words whole.

    Args:
        text: The text.
    """
    print_text(ERRORS, text)


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


def pasted(path: pathlib.Path | str) -> str:
    """A path as a shell takes it, in quotation marks where it needs them.

    Args:
        path: The path.

    Returns:
        What to paste.
    """
    if os.name == "nt":
        return subprocess.list2cmdline([str(path)])
    return shlex.quote(str(path))


def open_call(page: pathlib.Path) -> str:
    """How to look at a page on this system.

    Args:
        page: The page.

    Returns:
        The call.
    """
    opener = {"darwin": "open", "win32": "start"}.get(sys.platform, "xdg-open")
    return f"{opener} {pasted(page)}"


def plan_call(tuning: pathlib.Path) -> str:
    """How to plan a leg with a tuning.

    Args:
        tuning: Its tuning.json.

    Returns:
        The call.
    """
    out = pasted(tuning.with_name("plan.csv"))
    return (
        f'scdpr plan {pasted(tuning)} --from "0.3 m, 0.55 m" --to "1.9 m, 0.55 m" --out {out}'
    )
