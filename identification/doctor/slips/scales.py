"""Lengths and angles that are off by a factor, measured against each other."""

import dataclasses
import math
from collections.abc import Callable, Sequence

from identification.doctor.case import CAMERA_COLUMNS, Q3, Q4, Case, X, Y
from identification.doctor.relations.pairing import Pairing, pairings
from identification.doctor.slips.edits import ANGLES, POSITIONS, Undone, scaled
from identification.doctor.slips.slip import Slip
from identification.doctor.statistics import Slope, slope

RAD = math.pi / 180

ANGLE_FACTORS = (
    (RAD, "degrees as rad"),
    (1 / RAD, "rad as degrees"),
    (2 * math.pi, "revolutions as rad"),
    (0.5 / math.pi, "rad as revolutions"),
    (1 / 360, "degrees as revolutions"),
    (360.0, "revolutions as degrees"),
)
"""What undoes a unit of angle, and what it was."""

LENGTH_FACTORS = (
    (1e-3, "mm as m"),
    (1e3, "m as mm"),
    (1e-2, "cm as m"),
    (1e2, "m as cm"),
    (0.1, "mm as cm"),
    (10.0, "cm as mm"),
)
"""What undoes a unit of length, and what it was."""

NEAR = 0.03
"""How far a measured factor may be from a unit's and still be taken for it."""

LAGS = 0.25
"""The same for a camera's column: x_e swings and q_4 lags, and its units are tens apart."""

NAMEPLATE = 120.0
"""Factor that counts, a gearbox or a radius may be off."""

WHOLE = 30
"""Largest whole number that counts or gears are often off by."""

EXACT = 1e-3
"""How far a measured factor is from a whole one, as a share, by an elastic cable."""

CALIBRATED = 0.06
"""The same for what a camera's calibration makes of a whole one."""

CAMERA_RANGE = 1.4
"""Factor that a calibration of a camera may be off; beyond it, it is a unit."""


def _moving(case: Case) -> list[Pairing]:
    return [pair for pair in pairings(case) if pair.moves]


def _sure(fit: Slope | None) -> bool:
    return fit is not None and fit.value > 0 and abs(fit.correlation) > 0.9


def _axis_slope(case: Case, axis: str) -> Slope | None:
    """Camera over encoders on one axis, None where nothing tells it."""
    pairs = _moving(case)
    if axis == "x":
        fit = slope((pair.along, pair.position[:, Q3]) for pair in pairs)
    else:
        fit = slope((pair.up, pair.position[:, Y]) for pair in pairs)
    return fit if _sure(fit) else None


def _axis(case: Case, axis: str) -> float | None:
    fit = _axis_slope(case, axis)
    return None if fit is None else _tidy(fit)


def _both(case: Case) -> float | None:
    """Camera over encoders, one factor for both axes: their mean by their errors."""
    fits = [fit for axis in ("x", "y") if (fit := _axis_slope(case, axis))]
    if not fits:
        return None
    weights = [(fit.value / fit.sigma) ** 2 for fit in fits]
    logs = [weight * math.log(fit.value) for weight, fit in zip(weights, fits, strict=True)]
    mean = math.exp(math.fsum(logs) / math.fsum(weights))
    return _tidy(Slope(mean, mean / math.sqrt(math.fsum(weights)), 1.0))


def _tidy(fit: Slope) -> float:
    """The roundest factor that the slope allows.

    An elastic cable biases it by up to 0.1 %, more than its error says.
    """
    return round_number(fit.value, max(3 * fit.sigma, 1e-3 * fit.value))


def round_number(value: float, allowed: float) -> float:
    """The roundest number near a measured factor: slips are ratios of two nameplates.

    Args:
        value: The measured factor.
        allowed: How far the true one may be from it.

    Returns:
        A number of two decimals at most, or the inverse of one; else the factor itself.
    """
    for digits in (0, 1, 2):
        near = round(value, digits)
        if near > 0 and abs(value - near) < allowed:
            return float(near)
        near = round(1 / value, digits)
        if near > 0 and abs(value - 1 / near) < allowed:
            return 1 / near
    return value


def _nameplate(factor: float | None) -> bool:
    """Whether a factor is one of counts, gears and radii: none of a unit, and no wild one."""
    if factor is None or not 1 / NAMEPLATE < factor < NAMEPLATE:
        return False
    return all(abs(factor / unit - 1) > NEAR for unit, _ in ANGLE_FACTORS)


def _whole(factor: float, share: float) -> bool:
    """Whether a factor, or its inverse, is a whole number to some share."""
    larger = max(factor, 1 / factor)
    return 1.5 < larger < WHOLE and bool(abs(larger / round(larger) - 1) < share)


def companions(factor: float) -> tuple[str, ...]:
    """Slips that may be in a factor of the encoders beside that of counts, gears and radii.

    Args:
        factor: The factor.

    Returns:
        Their identifiers; none for a factor that is a whole number by itself.
    """
    if _whole(factor, EXACT):
        return ()
    unit = any(_whole(factor / unit, EXACT) for unit, _ in ANGLE_FACTORS)
    camera = _whole(factor, CALIBRATED)
    return ("unit.alpha",) * unit + ("scale.camera",) * camera


def _counts(case: Case) -> Undone | None:
    factor = _both(case)
    if not _nameplate(factor):
        return None
    undone = scaled(case, ANGLES, factor)
    rig = dataclasses.replace(case.rig, count=case.rig.count * factor)
    case = dataclasses.replace(undone.case, rig=rig)
    return undone._replace(case=case, also=companions(factor))


def _radius(case: Case) -> Undone | None:
    factor = _both(case)
    if not _nameplate(factor):
        return None
    radius = case.rig.radius * factor
    rig = dataclasses.replace(case.rig, radius=radius)
    step = {"do": "set effective_radius", "radius_m": radius}
    return Undone(dataclasses.replace(case, rig=rig), step, factor, companions(factor))


def _one_encoder(drive: int) -> Callable[[Case], float | None]:
    """One drive's angle as the camera sees it, over its encoder's."""
    sign = 1 - 2 * drive

    def measure(case: Case) -> float | None:
        fit = slope(
            (pair.along + sign * pair.up, pair.position[:, Q3] + sign * pair.position[:, Y])
            for pair in _moving(case)
        )
        return _tidy(fit) if _sure(fit) else None

    return measure


def _one_column(column: int) -> Callable[[Case], float | None]:
    """One camera column over what the encoders, or the carriages, expect of it."""

    def expected(pair: Pairing) -> object:
        return pair.up if column == Y else pair.along

    def measure(case: Case) -> float | None:
        fit = slope((pair.position[:, column], expected(pair)) for pair in _moving(case))
        return fit.value if _sure(fit) else None

    return measure


def _beside(column: int) -> Callable[[Case], float | None]:
    """The same over that of the other axis: encoders that are off by a factor cancel."""
    other = _one_column(Q3 if column == Y else Y)

    def measure(case: Case) -> float | None:
        own, others = _one_column(column)(case), other(case)
        return None if own is None or others is None else own / others

    return measure


def _in_unit(
    measure: Callable[[Case], float | None],
    columns: Sequence[str],
    factors: Sequence[tuple[float, str]],
    near: float = NEAR,
) -> Callable[[Case], Undone | None]:
    """One column's factor, if it is that of a unit."""

    def undo(case: Case) -> Undone | None:
        found = measure(case)
        if found is None:
            return None
        for factor, what in factors:
            if abs(found / factor - 1) < near:
                undone = scaled(case, columns, factor)
                return undone._replace(step={**undone.step, "what": what})
        return None

    return undo


def _off(
    measure: Callable[[Case], float | None], columns: Sequence[str]
) -> Callable[[Case], Undone | None]:
    """Encoder columns by their factor."""

    def undo(case: Case) -> Undone | None:
        factor = measure(case)
        return scaled(case, columns, factor) if _nameplate(factor) else None

    return undo


def _camera(
    measure: Callable[[Case], float | None], columns: Sequence[str]
) -> Callable[[Case], Undone | None]:
    """Camera columns by the inverse of camera over encoders, if it is a calibration's."""

    def undo(case: Case) -> Undone | None:
        factor = measure(case)
        if factor is None or not 1 / CAMERA_RANGE < factor < CAMERA_RANGE:
            return None
        return scaled(case, columns, 1 / factor)

    return undo


ONE_COLUMN_UNITS: tuple[Slip, ...] = (
    *(
        Slip("unit.alpha", column, _in_unit(_one_encoder(k), (column,), ANGLE_FACTORS))
        for k, column in enumerate(ANGLES)
    ),
    *(
        Slip(
            "unit.position",
            CAMERA_COLUMNS[column],
            _in_unit(_one_column(column), (CAMERA_COLUMNS[column],), LENGTH_FACTORS, LAGS),
        )
        for column in (X, Q3, Q4, Y)
    ),
    *(
        Slip(
            "unit.position",
            f"{CAMERA_COLUMNS[column]}, by the other axis",
            _in_unit(_beside(column), (CAMERA_COLUMNS[column],), LENGTH_FACTORS, LAGS),
        )
        for column in (X, Q3, Q4, Y)
    ),
)
"""One column in another unit than its header says."""

SCALES: tuple[Slip, ...] = (
    Slip("scale.camera", "camera lengths", _camera(_both, POSITIONS)),
    Slip("scale.alpha", "counts_per_rev", _counts),
    Slip("scale.alpha", "effective radius", _radius),
    Slip("scale.alpha", "encoder 1 alone", _off(_one_encoder(0), ANGLES[:1])),
    Slip("scale.alpha", "encoder 2 alone", _off(_one_encoder(1), ANGLES[1:])),
    Slip(
        "scale.camera",
        "its horizontal axis",
        _camera(lambda case: _axis(case, "x"), ("x_e", "q_3", "q_4")),
    ),
    Slip("scale.camera", "its vertical axis", _camera(lambda case: _axis(case, "y"), ("y_e",))),
)
"""Factors that are measured; the likelier first."""
