"""What the log doctor would put right, as changes to a mapping."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

DRIVE = ("voltage_1", "voltage_2", "alpha_1", "alpha_2", "drive t")
"""Columns of the drive's table, as the doctor calls them."""


def mapping_changes(
    findings: Iterable[tuple[str, Sequence[str], Mapping[str, Any]]],
) -> list[str]:
    """What to change in a mapping, a line each.

    Args:
        findings: Of each finding that can be put right its identifier, its runs, and its mend.

    Returns:
        The lines; none of them is done.
    """
    lines = []
    for identifier, runs, mend in findings:
        for step in mend["steps"]:
            where = step.get("run") or (", ".join(runs) if len(runs) <= 3 else "")
            lines += [f"{identifier}: {line}" for line in _lines(step, where)]
    return list(dict.fromkeys(lines))


def _lines(step: Mapping[str, Any], run: str) -> Iterator[str]:
    """The changes that do one step."""
    does, columns = step["do"], step.get("columns", ())
    if does == "scale":
        for column in columns:
            yield f"{_key(column)}: {_scaled(step['factor'])}"
    elif does == "count from the other end":
        for column in columns:
            yield f'{_key(column)}: sign = -1, offset = "{step["from"]:.6g} m"'
    elif does == "exchange":
        for first, second in columns:
            yield f"{_key(first)} and {second}: exchange what stands there"
    elif does == "write [knock]":
        start, duration = step["start"], step["duration"]
        yield f'[run.knock] of {run}: start = "{start}", duration = "{duration}"'
    elif does == "unwrap":
        yield (
            f"{_key(step['column'])} of {run}: wraps = what {step['period_rad']:.6g} rad are "
            "in the channel's unit"
        )
    elif does == "set kind":
        yield f'[[run]] {run}: kind = "{step["kind"]}"'
    elif does == "set effective_radius":
        yield f'[campaign.robot]: effective_radius = "{step["radius_m"]:.6g} m"'
    elif does == "leave the run out":
        yield f"[[run]] {run}: delete it"
    elif does == "leave [initial] out":
        yield f"[run.initial] of {run}: delete it"
    elif does.startswith("shift the camera's clock"):
        yield '[run.camera], or [defaults.camera]: clock_offset = "unknown"'
    elif does == "empty the cells":
        yield f"the columns {', '.join(columns)} of {run}: lost = the value that stands there"
    else:
        yield f"{does} in {run or 'every run'}: no mapping does it, `scdpr check --mend` does"


def _key(column: str) -> str:
    stream = "drive" if column in DRIVE or column == "drive t" else "camera"
    name = "t" if column.endswith(" t") else column
    return f"[{stream}.columns] {name}"


def _scaled(factor: float) -> str:
    if factor == -1:
        return "sign = -1 (1 where it is -1)"
    return f"scale = {factor:.9g} (times what it is)"
