"""Reading the JSON files that the verbs write, with one clear error."""

import json
import pathlib
from typing import Any, TypeVar

import pydantic
import pydantic_core

from scdpr_jax.numerics.files.given import RESULT, read_given
from scdpr_jax.numerics.files.harmless import printable, represented, shortened


class JsonObject(pydantic.BaseModel, strict=True, allow_inf_nan=False):
    """What a JSON file, or an object in it, has to hold: base of all of them.

    A number in quotation marks is text, and who wrote it meant something; NaN and Infinity
    are no numbers of JSON, though many programs write them.
    """


_Model = TypeVar("_Model", bound=JsonObject)


def read_json(path: pathlib.Path, model: type[_Model], *, expected: str, verb: str) -> _Model:
    """Read a JSON file as a model.

    Args:
        path: The file.
        model: What it has to hold.
        expected: Name of such a file, with its article: "a tuning.json".
        verb: The verb that writes it, "tune".

    Returns:
        What it holds.

    Raises:
        ValueError: If it can't be read or holds something else; says where.
    """
    path = pathlib.Path(path)
    try:
        content = read_given(path, most=RESULT)
    except OSError as error:
        raise ValueError(
            f"{path}: can't be read, got {error.strerror}, expected {expected}. Run "
            f"`scdpr {verb}` or `scdpr calibrate` first."
        ) from None
    try:
        return model.model_validate_json(content)
    except pydantic.ValidationError as error:
        raise ValueError(
            f"{path}: {_fault(content, error.errors()[0], expected)} Expected what "
            f"`scdpr {verb}` writes; write it anew."
        ) from None


_WRITTEN = (
    ({"robots", "controller"}, "a tuning.json, which `scdpr plan` takes"),
    ({"front", "leg"}, "a codesign.json, which `scdpr plan` takes"),
    ({"parameters"}, "a parameters.json, which `scdpr tune` takes"),
    ({"impulses", "compared"}, "a shaper.json of `scdpr shape`"),
    ({"findings"}, "the findings of `scdpr check`"),
)
"""What else the verbs write, by keys that it has."""


def _fault(content: bytes, first: dict[str, Any], expected: str) -> str:
    """What is wrong with a file, in words, and where."""
    if not content.strip():
        return f"the file is empty, got no text, expected {expected}."
    if first["type"] == "json_invalid":
        return _not_json(content, expected)
    there = pydantic_core.from_json(content)
    keys = set(there) if isinstance(there, dict) else set()
    for marks, name in _WRITTEN:
        if marks <= keys and name.split(",")[0] != expected:
            return f"this is another file, got {name}, expected {expected}."
    where = ".".join(str(part) for part in first["loc"]) or "the file"
    where = shortened(printable(where), 80)
    if first["type"] == "missing":
        return f"{where} is missing, got no such key, expected {expected}."
    got = represented(first["input"], 60)
    told = first["msg"][:1].lower() + first["msg"][1:]
    told = told.replace("input should be", "it should be").removeprefix("value error, ")
    return f"{where} is wrong, got {got}: {told}."


def _not_json(content: bytes, expected: str) -> str:
    """Where a text stops being JSON."""
    try:
        json.loads(content)
    except json.JSONDecodeError as error:
        ends = error.pos >= len(content.decode(errors="replace").rstrip())
        lines = error.doc.splitlines()
        row = min(error.lineno, len(lines))
        line = lines[row - 1][:60]
        if ends or error.msg.startswith("Unterminated"):
            return f"the file is cut, got its end in row {row}, after {line.strip()!r}."
        return f"row {row} isn't JSON, got {line.strip()!r}, expected {expected}."
    except UnicodeDecodeError as error:
        return f"it isn't text, got the byte 0x{content[error.start]:02x}, expected {expected}."
    except (RecursionError, ValueError):
        return f"it is nested too deeply, or has a number too long, expected {expected}."
    return f"the text isn't as the verbs write it, got another JSON, expected {expected}."
