"""A verb's arguments, and its help as `--help` prints it.

A docstring is broken for the width of the code. tyro keeps its line ends in the boxes and
breaks them again for the terminal, and leaves what is above the boxes to the terminal.
"""

import contextlib
import functools
import inspect
import io
import sys
from collections.abc import Callable, Iterator
from typing import Any

from experiments.page.wrapping import wrapped


def described(verb: Callable[..., int]) -> Callable[..., int]:
    """A verb whose arguments are told in a line each, for a terminal of any width.

    Args:
        verb: The verb.

    Returns:
        The same verb, its docstring's paragraphs joined.
    """

    @functools.wraps(verb)
    def same(*args: Any, **kwargs: Any) -> int:
        return verb(*args, **kwargs)

    # What is wrapped is where tyro looks for the docstring.
    del same.__wrapped__
    same.__signature__ = inspect.signature(verb)
    same.__doc__ = _joined(inspect.getdoc(verb) or "")
    return same


def _joined(text: str) -> str:
    """Arguments whose descriptions go on, further in than they began, in one line."""
    head, args, listed = text.partition("Args:\n")
    lines: list[str] = []
    for line in listed.splitlines():
        if lines and line.startswith("        "):
            lines[-1] += " " + line.strip()
        else:
            lines.append(line)
    return head + args + "\n".join(lines)


@contextlib.contextmanager
def fitted_help(columns: int) -> Iterator[None]:
    """Help that is printed meanwhile in so many columns, its words whole.

    Args:
        columns: Columns of the terminal.

    Yields:
        Nothing.
    """
    # tyro draws what the encoding has.
    kept = io.BytesIO()
    text = io.TextIOWrapper(kept, encoding=sys.stdout.encoding)
    try:
        with contextlib.redirect_stdout(text):
            yield
    finally:
        text.flush()
        for line in kept.getvalue().decode(text.encoding).splitlines():
            boxed = line.startswith(("│", "╭", "╰"))
            print("\n".join([line] if boxed else wrapped(line, columns)))
