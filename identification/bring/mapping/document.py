"""What stands in a mapping, as pydantic models, and what is wrong with one."""

import dataclasses
import difflib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError

from identification.campaign.faults import Fault
from identification.campaign.quantities import QuantityError, parse_quantity
from identification.campaign.schema import (
    CameraSigmaTable,
    CameraTable,
    CampaignDocument,
    InitialTable,
    KnockTable,
    PositiveNewtons,
    Seconds,
    SensorsTable,
)
from identification.campaign.tables.document import read_document, row_of
from identification.campaign.types import KINDS
from scdpr_jax.numerics.files.harmless import represented

_LOOKED_AT = 200
"""Problems of a mapping that are explained."""


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


def _hertz(value: object) -> float:
    if not isinstance(value, str):
        raise ValueError("not a text with a unit")
    rate = parse_quantity(value, unit="Hz")
    if not rate > 0:
        raise ValueError("not positive")
    return rate


class ClockTable(_Table):
    """`t` of a stream, or of one column on another clock."""

    channel: str | None = Field(None, examples=["Time"])
    unit: str | None = Field(None, examples=["ms"])
    rate: Annotated[float | None, BeforeValidator(_hertz)] = Field(None, examples=["1 kHz"])


class ColumnTable(ClockTable):
    """A column of a stream."""

    scale: float = Field(1.0, allow_inf_nan=False, examples=["1.0 (a number)"])
    sign: Literal[1, -1] = Field(1, examples=["-1 (or 1)"])
    offset: str | None = Field(None, examples=["0 mm"])
    wraps: float | None = Field(
        None, gt=0, allow_inf_nan=False, examples=["65536 (a number, in the channel's unit)"]
    )
    lost: list[float | int | str] = Field([], examples=["[0, -1] (a list)"])
    t: ClockTable | None = None


class StreamTable(_Table):
    """`[drive]`, `[camera]` or `[accelerometer]`: how every such log is read."""

    decimal: Literal[".", ","] | None = Field(None, examples=[","])
    separator: str | None = Field(None, min_length=1, examples=[";"])
    encoding: str | None = Field(None, examples=["utf-8"])
    skip: int | None = Field(None, ge=0, examples=["3 (a number)"])
    columns: dict[str, ColumnTable] = {}


class DefaultsTable(_Table):
    """`[defaults]`: what holds for every run that doesn't say otherwise."""

    kind: Literal[KINDS] | None = Field(None, examples=["torque_step"])
    pretension: PositiveNewtons | None = Field(None, examples=["350 N"])
    notes: str | None = Field(None, examples=["new cable"])
    initial: InitialTable | None = None
    knock: KnockTable | None = None
    camera: CameraTable | None = None


class RunTable(DefaultsTable):
    """A `[[run]]`."""

    name: str = Field(examples=["0001-torque-step"])
    drive_log: str | list[str] = Field(examples=["2026-11-30_001.tdms"])
    camera_log: str | list[str] | None = Field(None, examples=["pose_001.csv"])
    accelerometer_log: str | list[str] | None = Field(None, examples=["phone_001.csv"])
    begin: Seconds | None = Field(None, alias="from", examples=["12.5 s"])
    end: Seconds | None = Field(None, alias="to", examples=["31 s"])
    drive_columns: dict[str, ColumnTable] = {}
    camera_columns: dict[str, ColumnTable] = {}
    accelerometer_columns: dict[str, ColumnTable] = {}


class MappingDocument(_Table):
    """A mapping, without its format."""

    campaign: CampaignDocument | None = None
    defaults: DefaultsTable = DefaultsTable()
    run: list[RunTable] = Field(min_length=1)
    drive: StreamTable = StreamTable()
    camera: StreamTable = StreamTable()
    accelerometer: StreamTable = StreamTable()


_MODELS: Mapping[str, type[BaseModel]] = {
    "campaign": CampaignDocument,
    "defaults": DefaultsTable,
    "run": RunTable,
    "drive": StreamTable,
    "camera": StreamTable,
    "accelerometer": StreamTable,
    "initial": InitialTable,
    "knock": KnockTable,
}


def read_mapping(path: Path) -> tuple[MappingDocument | None, tuple[Fault, ...]]:
    """A mapping.

    Args:
        path: The file.

    Returns:
        What stands in it, None if there are faults; and the faults.
    """
    content, text, fault = read_document(path)
    if fault is not None:
        return None, (dataclasses.replace(fault, file=str(path)),)
    left_empty: list[str] = []
    filled = _filled(content, "", left_empty)
    try:
        return MappingDocument.model_validate(filled), ()
    except ValidationError as error:
        faults = [
            dataclasses.replace(each, file=str(path))
            for each in _faults(error, text, filled, left_empty)
        ]
        return None, tuple(dict.fromkeys(faults))


def _filled(content: Any, place: str, left_empty: list[str]) -> Any:
    """A document without what was left empty, and where that was."""
    if isinstance(content, list):
        return [
            _filled(each, f"{place}.{k}", left_empty)
            for k, each in enumerate(content)
            if each != ""
        ]
    if not isinstance(content, dict):
        return content
    kept = {}
    for key, value in content.items():
        if value == "" and key != "notes":
            left_empty.append(f"{place}.{key}".lstrip("."))
        else:
            kept[key] = _filled(value, f"{place}.{key}", left_empty)
    return kept


def _faults(
    error: ValidationError, text: str, content: Mapping[str, Any], left_empty: list[str]
) -> Iterator[Fault]:
    for problem in error.errors(include_url=False)[:_LOOKED_AT]:
        path = list(problem["loc"])
        words = [str(part) for part in path]
        fault = _explained(problem, words, ".".join(words) in left_empty)
        row = row_of(text, [word for word in words if not word.isdecimal()])
        yield dataclasses.replace(fault, row=row, key=_key(path, content))


def _key(path: list[Any], content: Mapping[str, Any]) -> str:
    """A key with its table; a run by its name."""
    if len(path) > 1 and path[0] == "run" and isinstance(path[1], int):
        runs = content.get("run", [])
        name = runs[path[1]].get("name") if isinstance(runs[path[1]], dict) else None
        first = f"run {name!r}" if name else f"run {path[1] + 1}"
        return ".".join([first, *map(str, path[2:])])
    return ".".join(map(str, path))


def _explained(problem: Any, words: list[str], empty: bool) -> Fault:
    """What pydantic found, in a mapping's words and without its place."""
    name = words[-1]
    table = _table(words)
    example = _example(table, name)
    kind = problem["type"]
    if kind == "extra_forbidden":
        known = [field.alias or key for key, field in table.model_fields.items()]
        near = difflib.get_close_matches(name[:80], known, n=1, cutoff=0.0)
        return Fault(
            what="an unknown key",
            got=represented(name),
            expected=f"one of {', '.join(known)}",
            remedy=f'The nearest is "{near[0]}"; delete the line if that isn\'t meant.',
        )
    if kind == "missing":
        return Fault(
            what="left empty" if empty else "a missing key",
            got="nothing",
            expected=example,
            remedy="Fill it in; nothing is imported by a guess.",
        )
    cause = problem.get("ctx", {}).get("error")
    if isinstance(cause, QuantityError):
        return Fault(
            what=cause.problem, got=cause.got, expected=cause.expected, remedy=cause.remedy
        )
    return Fault(
        what=problem["msg"][0].lower() + problem["msg"][1:],
        got=represented(problem["input"]),
        expected=example,
        remedy="Write it as in docs/import.md.",
    )


def _table(words: list[str]) -> type[BaseModel]:
    """The model of the table in which a key stands."""
    above = [word for word in words[:-1] if not word.isdecimal()]
    if not above:
        return MappingDocument
    if any(word == "columns" or word.endswith("_columns") for word in above[:-1]):
        return ClockTable if above[-1] == "t" else ColumnTable
    if "sensors" in above:
        return CameraSigmaTable if "runs" in above[:-1] else SensorsTable
    if above[-1] == "camera" and above[0] in ("run", "defaults"):
        return CameraTable
    return _MODELS.get(above[-1], MappingDocument)


def _example(table: type[BaseModel], name: str) -> str:
    fields = {field.alias or key: field for key, field in table.model_fields.items()}
    examples = fields[name].examples if name in fields else None
    if not examples:
        return f"a table [{name}]" if name != "run" else "a table [[run]] for each run"
    return f"{name} = {examples[0]}" if "(" in examples[0] else f'{name} = "{examples[0]}"'
