"""Faults of a `VISION.toml`, told together."""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from identification.campaign.faults import Fault, listed
from identification.campaign.quantities import QuantityError
from scdpr_jax.numerics.files.harmless import represented

_LINE = 400
_LOOKED_AT = 200
_HEADING = re.compile(r"\s*(\[{1,2})\s*([^\[\]]+?)\s*\]{1,2}")


class VisionError(ValueError):
    """A video, or what is said of it, that can't be used; its message has all the faults."""

    def __init__(self, path: Path, faults: Sequence[Fault]):
        self.faults = tuple(faults)
        """Every fault that was found."""
        number = "1 fault" if len(faults) == 1 else f"{len(faults)} faults"
        shown = listed(faults, file=path.name)
        super().__init__("\n".join([f"{path}: {number}.", *(f"  {each}" for each in shown)]))


def document_faults(
    error: ValidationError, model: type[BaseModel], text: str, *, file: str
) -> Iterator[Fault]:
    """What pydantic found, in this house's words and with its place.

    Args:
        error: What was found.
        model: Model of the document.
        text: The document.
        file: Its name.

    Yields:
        A fault for each.
    """
    empty = []
    for problem in error.errors(include_url=False)[:_LOOKED_AT]:
        if problem["input"] == "":
            empty.append(problem["loc"])
            continue
        path = [part for part in problem["loc"] if part not in ("str", "list[str]")]
        table, name = _field_of(model, path)
        yield Fault(
            file=file,
            row=row_of(text, path),
            key=key_of(path),
            **_words(problem, table, name),
        )
    if empty:
        yield Fault(
            file=file,
            row=row_of(text, empty[0]),
            key=key_of(empty[0]),
            what="empty" if len(empty) == 1 else f"empty, and so are {len(empty) - 1} more",
            expected="what is said behind it, with its unit",
            remedy=f"Fill in {', '.join(key_of(each) for each in empty)}.",
        )


def key_of(path: Sequence[str | int]) -> str:
    """A key as people say it, entries of lists counted from 1.

    Args:
        path: Names of tables, places in lists counted from 0, and the key.

    Returns:
        Like "marks 2.x".
    """
    words = ""
    for part in path:
        words += f" {part + 1}" if isinstance(part, int) else f".{part}"
    return words.removeprefix(".")


def row_of(text: str, path: Sequence[str | int]) -> int | None:
    """The line in which a key stands.

    Args:
        text: The document's text.
        path: Names of tables, places in lists, and the key.

    Returns:
        The line from 1: the key's, its table's if the key isn't there, or None.
    """
    heading, counts, table_row = "", {}, None
    wanted = [str(part) for part in path]
    for number, line in enumerate(text.splitlines(), start=1):
        match = _HEADING.match(line[:_LINE])
        if match is not None:
            heading = match[2]
            if match[1] == "[[":
                counts[heading] = counts.get(heading, -1) + 1
                heading = f"{heading}.{counts[heading]}"
            if heading in (".".join(wanted), ".".join(wanted[:-1])):
                table_row = number
        else:
            name = line[:_LINE].partition("=")[0].strip().strip("\"'")
            for length in range(1, len(wanted) + 1):
                whole = f"{heading}.{name}".removeprefix(".")
                if length > heading.count(".") and whole == ".".join(wanted[:length]):
                    return number
    return table_row


def _field_of(model: type[BaseModel], path: Sequence[str | int]) -> tuple[Any, str]:
    """The table that a path ends in, and the field's name."""
    table: Any = model
    name = ""
    for part in path:
        if isinstance(part, int):
            continue
        fields = getattr(table, "model_fields", None)
        if fields is None or part not in fields:
            name = name if fields is None else part
            inner = None
        else:
            name = part
            inner = next(iter(_models(fields[part].annotation)), None)
            if inner is None:
                return table, name
        if inner is not None and part != path[-1]:
            table = inner
    return table, name


def _models(annotation: Any) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for part in getattr(annotation, "__args__", ()):
        yield from _models(part)


def _words(problem: Any, table: Any, name: str) -> dict[str, str]:
    import difflib

    example = _example(table, name)
    if problem["type"] == "extra_forbidden":
        near = difflib.get_close_matches(name[:80], table.model_fields, n=1, cutoff=0.0)[0]
        return {
            "what": "an unknown key",
            "got": represented(name),
            "expected": f"one of {', '.join(table.model_fields)}",
            "remedy": f'Is it "{near}"? Delete the line if that isn\'t meant.',
        }
    if problem["type"] == "missing":
        return {
            "what": "a missing key",
            "got": "no such key",
            "expected": example,
            "remedy": f"Add a line like {example}",
        }
    cause = problem.get("ctx", {}).get("error")
    if isinstance(cause, QuantityError):
        return {
            "what": cause.problem,
            "got": cause.got,
            "expected": cause.expected,
            "remedy": cause.remedy,
        }
    message = problem["msg"]
    return {
        "what": message[0].lower() + message[1:],
        "got": represented(problem["input"]),
        "expected": example,
        "remedy": f"Write it like {example}",
    }


def _example(table: Any, name: str) -> str:
    field = table.model_fields.get(name)
    if field is None or field.examples is None:
        return f"a table with the heading [{name}]"
    written = str(field.examples[0])
    bare = written.startswith(("[", "colours.")) or "(" in written
    return f"{name} = {written}" if bare else f'{name} = "{written}"'
