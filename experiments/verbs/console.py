"""What the verbs share of the console: where they print, and how they end."""

import os
import pathlib
import shlex
import subprocess
import sys
from typing import TYPE_CHECKING, Annotated

import tyro
from rich.console import Console, ConsoleRenderable, RenderHook
from rich.text import Text

from scdpr_jax.numerics.files.harmless import printable

if TYPE_CHECKING:
    from experiments.runtime.store.store import Distrusted

from experiments.page.console_text import print_text

Folder = Annotated[pathlib.Path, tyro.conf.Positional]
"""A path that is given without a flag."""


class _Harmless(RenderHook):
    """What comes from a file can't move the cursor: a mark that would is shown as unknown."""

    def process_renderables(self, renderables: list[ConsoleRenderable]) -> list:
        """The texts without such marks.

        Args:
            renderables: What is to be shown.

        Returns:
            The same, where there are none.
        """
        return [_still(each) if isinstance(each, Text) else each for each in renderables]


def _still(text: Text) -> Text:
    kept = [mark if mark in "\n\t" or printable(mark) == mark else "�" for mark in text.plain]
    text.plain = "".join(kept)
    return text


_UNBOUNDED = 100_000


def _width(is_terminal: bool) -> int | None:
    """Columns to print in, None for those of the terminal."""
    return None if os.environ.get("COLUMNS") or is_terminal else _UNBOUNDED


# Without a height, a console whose terminal is a dumb one has 80 columns, whatever it is told.
OUT = Console(highlight=False, width=_width(sys.stdout.isatty()), height=25)
"""As wide as the terminal. A file or a pipe has no width: there a sentence is one line."""

ERRORS = Console(stderr=True, highlight=False, width=_width(sys.stderr.isatty()), height=25)
"""Progress and complaints."""

for _console in (OUT, ERRORS):
    _console.push_render_hook(_Harmless())


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


def tell_distrusted(found: "Distrusted") -> None:
    """Say what isn't used of what an earlier call has left.

    Args:
        found: What it is.
    """
    complain(f"{found.name}: {found.why}. It is computed anew.")
