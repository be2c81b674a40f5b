"""What stands in `campaign.toml` and `run.toml`, as pydantic models."""

import dataclasses
import difflib
import math
import typing
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationError,
    create_model,
)

from identification.campaign.faults import Fault, listed
from identification.campaign.quantities import LARGEST, QuantityError, parse_quantity
from identification.campaign.tables.document import read_document, row_of
from identification.campaign.types import KINDS
from scdpr_jax.numerics.files.harmless import represented
from scdpr_jax.robot.stated.names import QUANTITIES

_Model = TypeVar("_Model", bound=BaseModel)


def _reader(
    unit: str, *, above: float = -math.inf, least: float = -math.inf
) -> Callable[[object], float]:
    """What reads a quantity of a unit within bounds."""

    def read(value: object) -> float:
        if not isinstance(value, str):
            raise _misfit("not a text with a unit", value, unit, _example_number(value))
        number = parse_quantity(value, unit=unit)
        if above == 0 and not number >= 1 / LARGEST:
            raise _misfit("not positive", value, unit, f"{abs(number) or 1:g}")
        if not number >= least:
            raise _misfit("negative", value, unit, f"{abs(number):g}")
        return number

    return read


def _misfit(problem: str, got: object, unit: str, example: str) -> QuantityError:
    written = example if unit == "1" else f"{example} {unit}"
    bound = {"not positive": "above zero", "negative": "of zero or more"}.get(problem, "")
    return QuantityError(
        problem,
        name="quantity",
        got=represented(got),
        expected=f"a quantity {bound} [{unit}] in quotation marks".replace("  ", " "),
        remedy=f'Write it like "{written}".',
    )


def _example_number(value: object) -> str:
    """A number without a unit as it was written, or any number for something else."""
    text = represented(value)
    return text if type(value) in (int, float) and len(text) <= 20 else "0.5"


def _offset(value: object) -> float | None:
    return None if value == "unknown" else _reader("s")(value)


def _positive(unit: str) -> BeforeValidator:
    return BeforeValidator(_reader(unit, above=0.0))


Metres = Annotated[float, BeforeValidator(_reader("m"))]
Seconds = Annotated[float, BeforeValidator(_reader("s"))]
PositiveMetres = Annotated[float, _positive("m")]
PositiveSeconds = Annotated[float, _positive("s")]
PositiveNewtons = Annotated[float, _positive("N")]
PositiveRadians = Annotated[float, _positive("rad")]
Offset = Annotated[float | None, BeforeValidator(_offset)]


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class InitialTable(_Table):
    """`[initial]` of a run."""

    x_e: Metres = Field(examples=["0.173 m"])
    y_e: Metres = Field(examples=["0.300 m"])
    placement_sigma: PositiveMetres = Field(1e-3, examples=["1 mm"])


class KnockTable(_Table):
    """`[knock]` of a run."""

    start: Seconds = Field(examples=["0.3 s"])
    duration: PositiveSeconds = Field(examples=["30 ms"])


class CameraTable(_Table):
    """`[camera]` of a run."""

    clock_offset: Offset = Field(0.0, examples=["0 ms"])


class RunDocument(_Table):
    """`run.toml`, without its format."""

    kind: Literal[KINDS] = Field(examples=["torque_step"])
    pretension: PositiveNewtons = Field(examples=["350 N"])
    notes: str = Field("", examples=["experiment 1 of Table 2"])
    initial: InitialTable | None = None
    knock: KnockTable | None = None
    camera: CameraTable = CameraTable()


class CameraSigmaTable(_Table):
    """`[sensors.runs.NAME]` of a campaign: one run's camera, where it isn't the campaign's."""

    x_e: PositiveMetres | None = Field(None, examples=["0.05 mm"])
    y_e: PositiveMetres | None = Field(None, examples=["0.05 mm"])
    y_e_offset: PositiveMetres | None = Field(None, examples=["0.05 mm"])
    delta_e: PositiveRadians | None = Field(None, examples=["0.2 mrad"])
    q_3: PositiveMetres | None = Field(None, examples=["0.05 mm"])
    q_4: PositiveMetres | None = Field(None, examples=["0.05 mm"])


class SensorsTable(_Table):
    """`[sensors]` of a campaign."""

    encoder_sigma: PositiveRadians | None = Field(None, examples=["0.1 mrad"])
    camera_position_sigma: PositiveMetres | None = Field(None, examples=["0.19 mm"])
    camera_angle_sigma: PositiveRadians | None = Field(None, examples=["2 mrad"])
    runs: dict[str, CameraSigmaTable] = {}


RobotTable = create_model(
    "RobotTable",
    __base__=_Table,
    __doc__="`[robot]` of a campaign: the named quantities, None where not given.",
    **{
        quantity.name: (
            Annotated[
                float | None,
                _positive(quantity.unit)
                if quantity.positive
                else BeforeValidator(_reader(quantity.unit, least=0.0)),
            ],
            None,
        )
        for quantity in QUANTITIES
    },
)


class CampaignDocument(_Table):
    """`campaign.toml`, without its format."""

    name: str = Field("", examples=["rig A, 2026-11"])
    counts_per_rev: float | None = Field(
        None,
        gt=1e-12,
        lt=1e15,
        allow_inf_nan=False,
        examples=["26624 (a number without quotation marks)"],
    )
    robot: RobotTable = RobotTable()
    sensors: SensorsTable = SensorsTable()


def read_model(
    path: Path, model: type[_Model], *, file: str
) -> tuple[_Model | None, tuple[Fault, ...]]:
    """A TOML file of a model.

    Args:
        path: The file.
        model: `CampaignDocument` or `RunDocument`.
        file: The file, relative to the campaign's folder.

    Returns:
        What stands in it, None if there are faults; and the faults.
    """
    document, text, fault = read_document(path)
    if fault is not None:
        return None, listed([fault], file=file)
    try:
        return model.model_validate(document), ()
    except ValidationError as error:
        faults = _faults(error, model, text)
        return None, listed(faults, file=file, count=error.error_count())


def _faults(error: ValidationError, model: type[BaseModel], text: str) -> Iterator[Fault]:
    for problem in error.errors(include_url=False):
        path = [str(part) for part in problem["loc"]]
        fault = _explained(problem, model, path)
        yield dataclasses.replace(fault, row=row_of(text, path), key=".".join(path))


def _explained(problem: Any, model: type[BaseModel], path: list[str]) -> Fault:
    """What pydantic found, in this format's words and without its place."""
    table, name = _table_of(model, path[:-1]), path[-1]
    if problem["type"] == "extra_forbidden":
        return _unknown_key(model, table, name, got=problem["input"])
    example = _example(table, name)
    if problem["type"] == "missing":
        remedy = f"Add a line like {example}"
        return Fault(what="a missing key", got="no such key", expected=example, remedy=remedy)
    if problem["type"] == "value_error":
        cause = problem["ctx"]["error"]
        return Fault(
            what=cause.problem, got=cause.got, expected=cause.expected, remedy=cause.remedy
        )
    got = represented(problem["input"])
    if problem["type"] == "literal_error":
        near = difflib.get_close_matches(got, KINDS, n=1)
        remedy = f'Is it "{near[0]}"?' if near else '"free" takes what fits no other kind.'
        kinds = f"one of {', '.join(KINDS)}"
        return Fault(what="an unknown kind", got=got, expected=kinds, remedy=remedy)
    what = problem["msg"][0].lower() + problem["msg"][1:]
    return Fault(what=what, got=got, expected=example, remedy=f"Write it like {example}")


def _example(table: type[BaseModel], name: str) -> str:
    field = table.model_fields.get(name)
    if table is SensorsTable and (field is None or name == "runs"):
        return f"a table with the heading [sensors.runs.{'NAME' if field else name}]"
    examples = field.examples
    if examples is None:
        return f"a table with the heading [{name}]"
    return f"{name} = {examples[0]}" if "(" in examples[0] else f'{name} = "{examples[0]}"'


def _unknown_key(
    model: type[BaseModel], table: type[BaseModel], name: str, *, got: object
) -> Fault:
    """The fault of a key that its table doesn't have: it belongs elsewhere, or is misspelt."""
    near = difflib.get_close_matches(name[:80], table.model_fields, n=1, cutoff=0.0)
    remedy = f'The nearest known key is "{near[0]}"; delete the line if that isn\'t meant.'
    homes = [key for key, other in _tables(model).items() if name in other.model_fields]
    if homes and not isinstance(got, dict):
        place = f"below the heading [{homes[0]}]" if homes[0] else "above the first [table]"
        remedy = f"It belongs {place}."
    keys = f"one of {', '.join(table.model_fields)}"
    return Fault(what="an unknown key", got=represented(name), expected=keys, remedy=remedy)


def _table_of(model: type[BaseModel], above: list[str]) -> type[BaseModel]:
    """The table that stands below the names of a heading."""
    of_run = above[:2] == ["sensors", "runs"]
    if of_run:
        return CameraSigmaTable if len(above) > 2 else SensorsTable
    return _tables(model)[".".join(above)]


def _tables(model: type[BaseModel]) -> dict[str, type[BaseModel]]:
    """A document's tables by their headings; above the first stands the document itself."""
    inner = {
        name: candidate
        for name, field in model.model_fields.items()
        for candidate in (field.annotation, *typing.get_args(field.annotation))
        if isinstance(candidate, type) and issubclass(candidate, BaseModel)
    }
    return {"": model, **inner}
