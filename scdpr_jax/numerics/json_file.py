"""Reading the JSON files that the verbs write, with one clear error."""

import pathlib
from typing import TypeVar

import pydantic

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
        return model.model_validate_json(read_given(path, most=RESULT))
    except OSError as error:
        raise ValueError(
            f"{path}: can't be read, got {error.strerror}, expected {expected}. Run "
            f"`scdpr {verb}` or `scdpr calibrate` first."
        ) from None
    except pydantic.ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"]) or "the file"
        got = first["input"] if isinstance(first["input"], str) else represented(first["input"])
        raise ValueError(
            f"{path}: {shortened(printable(where), 80)} is wrong, got {represented(got, 60)}: "
            f"{first['msg']}. "
            f"Expected what `scdpr {verb}` writes; write it anew."
        ) from None
