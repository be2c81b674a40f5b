"""A verb's arguments, and its help as `--help` prints it.

A docstring is broken for the width of the code. tyro keeps its line ends in the boxes and
breaks them again for the terminal, and leaves what is above the boxes to the terminal.
"""

import contextlib
import difflib
import functools
import inspect
import io
import sys
from collections.abc import Callable, Iterator, Sequence
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


def check_options(verb: Callable[..., int], arguments: Sequence[str]) -> None:
    """Refuse an option that the verb hasn't, with the one that was meant.

    Args:
        verb: The verb.
        arguments: What it is called with.

    Raises:
        ValueError: If an option isn't the verb's, and is near one that is.
    """
    known = {"--help"}
    for name, parameter in inspect.signature(verb).parameters.items():
        if parameter.kind is inspect.Parameter.POSITIONAL_ONLY:
            continue
        named = [m.name for m in getattr(parameter.annotation, "__metadata__", ()) if _names(m)]
        option = (named or [name])[0].replace("_", "-")
        known |= {f"--{option}", f"--no-{option}"}
    for argument in arguments:
        option = argument.partition("=")[0].replace("_", "-")
        if not option.startswith("--") or option in known:
            continue
        options = sorted(each for each in known if not each.startswith("--no-"))
        near = [each for each in options if option.startswith(each) or each.startswith(option)]
        near = near or difflib.get_close_matches(option, options, n=1)
        if near:
            raise ValueError(
                f"no option {argument.partition('=')[0]!r}, expected one of: "
                f"{', '.join(options)}. Did you mean `{near[0]}`?"
            )


def _names(metadata: object) -> bool:
    """Whether what annotates a parameter gives its option another name."""
    return getattr(metadata, "name", None) is not None


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
