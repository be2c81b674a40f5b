"""The log doctor's word on a proposal: slips of signs, plugs and units changed in its lines."""

import math
from collections.abc import Iterable, Mapping
from typing import Any

from identification.bring.proposal.choice import Choice
from identification.campaign.tables.columns import CAMERA, drive_columns
from identification.doctor.findings import Finding

_SCALES = "scale."
"""Findings that a proposal leaves alone: how far off a calibration is, a person measures."""

Choices = dict[str, dict[str, Choice]]
"""Of each stream its columns' choices."""


def mended(choices: Choices, findings: Iterable[Finding]) -> tuple[Choices, list[str]]:
    """A proposal with what the doctor would put right.

    Args:
        choices: The proposal.
        findings: What the doctor found in its runs.

    Returns:
        The changed proposal, and what was changed, a line each; what holds for single runs
        alone isn't changed.
    """
    changed = {stream: dict(columns) for stream, columns in choices.items()}
    told = []
    for finding in findings:
        of_scale = finding.id.startswith(_SCALES)
        if finding.mend is None or finding.severity == "note" or of_scale:
            continue
        steps = finding.mend["steps"]
        if sum(_apply(changed, step, finding.what) for step in steps):
            told.append(f"{finding.id}: {finding.what}")
    return changed, list(dict.fromkeys(told))


def _apply(choices: Choices, step: Mapping[str, Any], why: str) -> bool:
    does = step["do"]
    if does == "scale":
        return sum(_scale(choices, name, step["factor"], why) for name in step["columns"]) > 0
    if does == "exchange":
        return sum(_exchange(choices, *pair, why) for pair in step["columns"]) > 0
    if does == "count from the other end":
        return sum(_mirror(choices, name, step["from"], why) for name in step["columns"]) > 0
    return False


def _home(choices: Choices, name: str) -> dict[str, Choice] | None:
    return next((columns for columns in choices.values() if name in columns), None)


def _scale(choices: Choices, name: str, factor: float, why: str) -> bool:
    if name in ("drive t", "camera t"):
        stream, column = name.split()
        home, name = choices[stream], column
    else:
        home = _home(choices, name)
    if home is None or name not in home:
        return False
    choice = home[name]
    if not choice.unit and factor != -1:
        return False  # of a unit that nothing tells, a factor tells nothing
    if factor == -1:
        home[name] = choice.because(why, sign=-choice.sign)
    elif (unit := _other_unit(name, choice.unit, factor)) is not None:
        home[name] = choice.because(why, unit=unit)
    else:
        home[name] = choice.because(why, scale=choice.scale * factor)
    return True


def _other_unit(name: str, unit: str, factor: float) -> str | None:
    """The unit that a factor makes of another one."""
    columns = {column.name: column for column in (*drive_columns(None), *CAMERA)}
    units = columns[name].units if name in columns else {}
    if unit not in units:
        return None
    size = {each: float(scale.factor) * 10.0**scale.exponent for each, scale in units.items()}
    for other, value in size.items():
        if abs(math.log(value / (size[unit] * factor))) < 1e-3:
            return other
    return None


def _exchange(choices: Choices, first: str, second: str, why: str) -> bool:
    home = _home(choices, first)
    if home is None or second not in home:
        return False
    home[first], home[second] = home[second].because(why), home[first].because(why)
    return True


def _mirror(choices: Choices, name: str, size: float, why: str) -> bool:
    home = _home(choices, name)
    if home is None:
        return False
    choice = home[name]
    home[name] = choice.because(why, sign=-choice.sign, offset=f"{size:.9g} m")
    return True
