"""What the verbs share of the console: where they print, and how they end."""

import pathlib
from typing import TYPE_CHECKING, Annotated

import tyro
from rich.console import Console, ConsoleRenderable, RenderHook
from rich.text import Text

from scdpr_jax.numerics.files.harmless import printable

if TYPE_CHECKING:
    from experiments.runtime.store.store import Distrusted

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


OUT = Console(highlight=False, width=max(140, Console().width))
"""Wide enough for the tables: a narrow terminal wraps them, and nothing is cut."""

ERRORS = Console(stderr=True, highlight=False)
"""Progress and complaints."""

for _console in (OUT, ERRORS):
    _console.push_render_hook(_Harmless())


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
