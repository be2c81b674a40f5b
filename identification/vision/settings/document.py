"""What stands in `VISION.toml`, as pydantic models in SI units and radians."""

import math
from collections.abc import Callable
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator

from identification.campaign.quantities import QuantityError, parse_quantity

BODIES = ("end_effector", "lower_carriage", "upper_carriage")
"""What a marker can be on."""
MIDDLE_STAMP = "middle row, mid exposure"
"""A stamp that is the time at which the pictures are taken."""
FIRST_STAMP = "first row, start of exposure"
"""A stamp that is earlier by half of the exposure and half of the readout."""


def _reader(
    unit: str, *, least: float = -math.inf, above: float = -math.inf
) -> Callable[[Any], float]:
    """What reads a quantity of a unit within bounds; 0 needs none."""

    def read(value: Any) -> float:
        if value == 0 and type(value) in (int, float) and least <= 0 and above < 0:
            return 0.0
        if not isinstance(value, str):
            raise QuantityError(
                "not a text with a unit",
                name="quantity",
                got=repr(value)[:80],
                expected=f"a quantity [{unit}] in quotation marks",
                remedy=f'Write it like "0.5 {unit}".',
            )
        number = parse_quantity(value, unit=unit)
        if number < least or number <= above:
            raise QuantityError(
                "not positive" if number <= above else "negative",
                name="quantity",
                got=repr(value),
                expected=f"more than zero [{unit}]" if number <= above else f"0 {unit} or more",
                remedy="Correct its sign.",
            )
        return number

    return read


Metres = Annotated[float, BeforeValidator(_reader("m"))]
PositiveMetres = Annotated[float, BeforeValidator(_reader("m", above=0.0))]
Seconds = Annotated[float, BeforeValidator(_reader("s"))]
Duration = Annotated[float, BeforeValidator(_reader("s", least=0.0))]
Hertz = Annotated[float, BeforeValidator(_reader("Hz", above=0.0))]
Share = Annotated[float, BeforeValidator(_reader("1", least=0.0)), Field(le=1.0)]
Angle = Annotated[float, BeforeValidator(_reader("rad"))]


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Time(_Table):
    """`[time]`: when the rows of which picture were exposed."""

    frame_rate: Hertz | None = Field(None, examples=["30 Hz"])
    stamps: str | None = Field(None, examples=["frames.csv"])
    first_frame: Seconds = Field(0.0, examples=["0.05 s"])
    exposure: Duration = Field(0.0, examples=["4 ms"])
    readout: Duration = Field(0.0, examples=["22 ms"])
    readout_direction: Literal["down", "up"] = Field("down", examples=["down"])
    stamp_at: Literal["middle row, mid exposure", "first row, start of exposure"] = Field(
        MIDDLE_STAMP, examples=[MIDDLE_STAMP]
    )

    @model_validator(mode="after")
    def _one_clock(self) -> "Time":
        if (self.frame_rate is None) == (self.stamps is None):
            raise QuantityError(
                "no clock" if self.stamps is None else "two clocks",
                name="time",
                got="neither" if self.stamps is None else "both",
                expected='frame_rate = "30 Hz" or stamps = "frames.csv"',
                remedy="Say one of them; stamps are right where frames are dropped.",
            )
        return self


class Calibration(_Table):
    """`[calibration]`: the lens, from photos of a board or as OpenCV's numbers."""

    photos: str | list[str] | None = Field(None, examples=["board/*.jpg"])
    inner_corners: tuple[int, int] | None = Field(None, examples=["[9, 6]"])
    square: PositiveMetres | None = Field(None, examples=["40 mm"])
    matrix: (
        tuple[
            tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]
        ]
        | None
    ) = Field(None, examples=["[[1250, 0, 816], [0, 1250, 612], [0, 0, 1]]"])
    distortion: list[float] = Field([], examples=["[-0.11, 0.045, 0, 0, 0]"])

    @model_validator(mode="after")
    def _one_source(self) -> "Calibration":
        given = [self.photos is not None, self.matrix is not None]
        if sum(given) != 1 or (self.photos and not (self.inner_corners and self.square)):
            raise QuantityError(
                "no lens" if sum(given) != 2 else "two lenses",
                name="calibration",
                got=", ".join(sorted(self.model_fields_set)) or "nothing",
                expected="photos, inner_corners and square of a chessboard; or matrix",
                remedy="Take ten photos of a board with the camera as it films the rig.",
            )
        if len(self.distortion) not in (0, 4, 5, 8, 12, 14):
            raise QuantityError(
                "not OpenCV's distortion",
                name="distortion",
                got=f"{len(self.distortion)} numbers",
                expected="4, 5, 8, 12 or 14: k1, k2, p1, p2, k3, …",
                remedy="Fill up with zeros.",
            )
        return self


class Colour(_Table):
    """`[colours.NAME]`: what counts as a colour."""

    hue: tuple[Angle, Angle] = Field(examples=['["100 deg", "170 deg"]'])
    saturation: tuple[Share, Share] = Field((0.35, 1.0), examples=['["45 %", "100 %"]'])
    value: tuple[Share, Share] = Field((0.12, 1.0), examples=['["12 %", "100 %"]'])


def _named(hue_from: int, hue_to: int) -> Colour:
    return Colour(hue=(f"{hue_from} deg", f"{hue_to} deg"))


WORDS: dict[str, Colour] = {
    "red": _named(340, 20),
    "orange": _named(20, 40),
    "yellow": _named(38, 68),
    "green": _named(85, 170),
    "cyan": _named(170, 200),
    "blue": _named(195, 250),
    "magenta": _named(285, 340),
}
"""Colours that a word alone stands for."""


def _colour(value: Any) -> Any:
    if not isinstance(value, str):
        return value
    if value not in WORDS:
        raise QuantityError(
            "not a colour that is known by its name",
            name="colour",
            got=repr(value),
            expected=f"one of {', '.join(WORDS)}",
            remedy="Say its hue, saturation and value in a table.",
        )
    return WORDS[value]


class _Spot(_Table):
    """What marks and markers share: a coloured disc, or an ArUco tag."""

    name: str = Field("", examples=["lower_left"])
    x: Metres = Field(examples=["-45 mm"])
    y: Metres = Field(examples=["-45 mm"])
    colour: str | None = Field(None, examples=["yellow"])
    diameter: PositiveMetres | None = Field(None, examples=["44 mm"])
    aruco: Annotated[int, Field(ge=0)] | None = Field(None, examples=["7 (a number)"])

    @model_validator(mode="after")
    def _one_look(self) -> "_Spot":
        disc = self.colour is not None and self.diameter is not None
        if disc == (self.aruco is not None) or (self.aruco is not None and self.colour):
            raise QuantityError(
                "neither a disc nor a tag" if self.aruco is None else "a disc and a tag",
                name="colour",
                got=", ".join(k for k in ("colour", "diameter", "aruco") if getattr(self, k))
                or "nothing",
                expected='colour = "yellow" and diameter = "44 mm", or aruco = 7',
                remedy="Say what it looks like.",
            )
        return self


class Mark(_Spot):
    """`[[marks]]`: fixed, in the frame's coordinates."""

    z: Metres = Field(0.0, examples=["0 mm"])
    near: tuple[float, float] | None = Field(None, examples=["[154, 962]"])


class Marker(_Spot):
    """`[[markers]]`: on a body that moves, from the body's origin."""

    body: Literal["end_effector", "lower_carriage", "upper_carriage"] = Field(
        examples=["end_effector"]
    )
    depth: Metres = Field(0.0, examples=["20 mm"])


class Vision(_Table):
    """`VISION.toml`, without its format."""

    video: str = Field(examples=["video.avi"])
    dictionary: str = Field("4X4_50", examples=["4X4_50"])
    frame_height: PositiveMetres | None = Field(None, examples=["1112 mm"])
    time: Time
    calibration: Calibration
    colours: dict[str, Annotated[Colour, BeforeValidator(_colour)]] = Field(
        default_factory=dict, examples=['colours.green = "green"']
    )
    marks: tuple[Mark, ...] = Field(examples=["[[marks]]"])
    markers: tuple[Marker, ...] = Field(examples=["[[markers]]"])
