"""What explains each identifier, and what to do about it, in words."""

from collections.abc import Iterable, Mapping
from typing import Any, Literal, NamedTuple

from identification.doctor.findings import Finding, Severity


class Words(NamedTuple):
    """An identifier's cause and remedy."""

    cause: str
    """What explains it."""
    remedy: str
    """How to put it right."""


_UNIT = "Correct the unit in the header of the file, or let --mend do it."
_PLUG = "Correct the wiring or the logger for the next campaign; let --mend put this one right."
_CLOCK = 'State `clock_offset` in [camera], or write "unknown"; --mend estimates it.'
_LOG = "Export the log again, or leave the run out."

WORDS: Mapping[str, Words] = {
    "unit.alpha": Words("The encoder angles are in another unit than the header says.", _UNIT),
    "unit.delta_e": Words("The rotation is in another unit than the header says.", _UNIT),
    "unit.position": Words("Camera lengths are in another unit than the header says.", _UNIT),
    "unit.voltage": Words("The commands are in another unit than the header says.", _UNIT),
    "unit.time_drive": Words("The drive's time is in another unit.", _UNIT),
    "unit.time_camera": Words("The camera's time is in another unit.", _UNIT),
    "unit.time": Words("The time of both streams is in another unit.", _UNIT),
    "rate.drive": Words(
        "The drive's samples are stamped at another rate than they were taken.",
        "Stamp them with the controller's own period, or let --mend do it.",
    ),
    "sign.motor_1": Words("Drive 1 is mounted, or wired, the other way round.", _PLUG),
    "sign.motor_2": Words("Drive 2 is mounted, or wired, the other way round.", _PLUG),
    "sign.voltage_1": Words("The command of drive 1 is logged with the other sign.", _PLUG),
    "sign.voltage_2": Words("The command of drive 2 is logged with the other sign.", _PLUG),
    "sign.alpha_1": Words("Encoder 1 counts the other way.", _PLUG),
    "sign.alpha_2": Words("Encoder 2 counts the other way.", _PLUG),
    "sign.x_e": Words(
        "The camera's horizontal axis counts to the left.",
        "Give x from the lower left corner of the frame, to the right; --mend turns it.",
    ),
    "sign.y_e": Words(
        "The camera's vertical axis counts downwards, as image coordinates do.",
        "Give y from the lower left corner of the frame, upwards; --mend turns it.",
    ),
    "sign.delta_e": Words(
        "The rotation counts the other way.",
        "Count it as the line between the carriages turns; --mend turns it.",
    ),
    "swap.motors": Words("Drives 1 and 2 are exchanged.", _PLUG),
    "swap.voltages": Words("The commands of drives 1 and 2 are exchanged.", _PLUG),
    "swap.alphas": Words("The encoders of drives 1 and 2 are exchanged.", _PLUG),
    "swap.carriages": Words(
        "q_3 and q_4 are exchanged: the drives move the lower carriage.",
        "q_3 is the lower carriage; --mend exchanges the columns.",
    ),
    "scale.alpha": Words(
        "`counts_per_rev` or the pulleys' radius is off by a factor.",
        "Check counts_per_rev (four edges a pulse, times the gearbox) and effective_radius.",
    ),
    "scale.camera": Words(
        "The camera's lengths are off by a factor.",
        "Calibrate the camera in the plane of the end-effector; --mend scales it.",
    ),
    "clock.offset": Words("The camera's clock isn't what the run states.", _CLOCK),
    "clock.drift": Words("The camera's clock runs at another rate than the drive's.", _CLOCK),
    "wrap.alpha": Words(
        "The angle wraps: a counter overflows, or the angle is kept within a turn.",
        "Unwrap it when logging; --mend does it here.",
    ),
    "jump.alpha": Words(
        "The encoder lost or gained counts.",
        "Check the encoder's line and its counter; --mend takes the jump out.",
    ),
    "stuck.alpha": Words(
        "The encoder stands still under a command that must move it.",
        "Check the encoder and its line, and repeat the run.",
    ),
    "stuck.voltage": Words(
        "The command is logged as a constant while its drive moves.",
        "Log the command after saturation, and repeat the run.",
    ),
    "stuck.camera": Words(
        "The camera repeats a value while what it sees must move.",
        "Check the tracker; --mend empties these cells.",
    ),
    "lost_as_value": Words(
        "A lost marker was written as a value.",
        "Leave the cell empty where the marker was lost; these frames don't count.",
    ),
    "swapped_marker": Words(
        "Single frames show another marker.",
        "Nothing to do for a few: they don't count. For many, check light and markers.",
    ),
    "gap.drive": Words(
        "The drive's samples are missing, and what was commanded meanwhile isn't known.",
        "Log from the controller's own loop; a fit takes the pieces whose begin is seen.",
    ),
    "gap.camera": Words(
        "The vision system didn't keep up.",
        "Nothing to do for a few; for many, lower the frame rate.",
    ),
    "time.jump": Words(
        "The clock was set, or the logger was restarted, within the run.",
        "Log on a clock that isn't set while it runs; --mend closes the jump.",
    ),
    "knock.missing": Words(
        "A pseudo-impulse without [knock].",
        "Add [knock] with its start and duration; --mend writes what was found.",
    ),
    "knock.wrong": Words(
        "The stated time isn't when it was knocked.",
        "Correct [knock], on the drive's clock; --mend writes what was found.",
    ),
    "start.moving": Words(
        "The run doesn't begin at rest.",
        "Wait for standstill before logging; with --accept a fit estimates its start "
        "velocities, --mend leaves the run out.",
    ),
    "label.kind": Words(
        "The run isn't what its kind says.",
        "Correct `kind` in run.toml.",
    ),
    "label.initial": Words(
        "The camera doesn't see the run begin where [initial] says.",
        "Correct [initial] in run.toml, or delete it; --mend leaves it out.",
    ),
    "label.duplicate": Words(
        "The same run is in the campaign twice, and would count twice.",
        "Delete one of them; --mend leaves the later one out.",
    ),
    "command.before_limit": Words(
        "The command was logged before saturation.",
        "Log it after saturation, or set `voltage_limit` in [robot]; --mend clips it.",
    ),
    "excitation.none": Words(
        "A run in which nothing moves tells nothing but the noise.",
        "Check the logged signals, or leave the run out.",
    ),
    "excitation.poor": Words(
        "What moves doesn't tell everything that a fit asks.",
        "Add runs that move what is missing, or hold these quantities at known values.",
    ),
    "pose.outside": Words(
        "The pose is out of the frame or of reach.",
        "Check the origin and [initial], or set the frame's size in [robot].",
    ),
    "unexplained": Words(
        "No single slip that is known here explains it, nor do two.",
        "Check wiring, units and clocks of these runs; another rig would look so, too.",
    ),
}
"""Cause and remedy of every identifier."""


def finding(
    identifier: str,
    severity: Severity,
    *,
    runs: Iterable[str],
    what: str,
    stream: Literal["drive", "camera"] | None = None,
    column: str | None = None,
    row: int | None = None,
    evidence: Mapping[str, Any],
    mend: Mapping[str, Any] | None = None,
) -> Finding:
    """A finding with its identifier's words.

    Args:
        identifier: Its identifier.
        severity: How much it matters.
        runs: Names of the runs that show it.
        what: What was seen, with its figures.
        stream: The stream in which it is.
        column: The column.
        row: Index of the sample, from 0.
        evidence: The figures [SI].
        mend: One step that puts it right.

    Returns:
        The finding.
    """
    words = WORDS[identifier]
    return Finding(
        id=identifier,
        severity=severity,
        runs=tuple(runs),
        stream=stream,
        column=column,
        row=None if row is None else row + 2,  # the header is line 1
        evidence=evidence,
        what=what,
        cause=words.cause,
        remedy=words.remedy,
        mend=None if mend is None else {"steps": [mend]},
    )


def explained(
    identifier: str,
    slip: str,
    step: Mapping[str, Any],
    *,
    figures: Iterable[tuple[str, str, Mapping[str, Any]]],
    runs: Iterable[str],
    alternatives: tuple[str, ...],
) -> Finding:
    """A contradiction that a slip explains.

    Args:
        identifier: The slip's identifier.
        slip: What happened, more exactly.
        step: What puts it right.
        figures: Name, words and figures of each relation that doesn't hold, the worst first.
        runs: Names of the runs.
        alternatives: Identifiers that explain it nearly as well.

    Returns:
        The finding.
    """
    figures, words, runs = tuple(figures), WORDS[identifier], tuple(runs)
    columns = step.get("columns", ())
    single = columns[0] if len(columns) == 1 and isinstance(columns[0], str) else None
    return Finding(
        id=identifier,
        severity="contradiction",
        runs=runs,
        stream=_stream(single),
        column=None if single is None else single.split()[-1],
        evidence={name: values for name, _, values in figures},
        what="; ".join(what for _, what, _ in figures[:3]),
        cause=f"{words.cause} ({slip})",
        remedy=words.remedy,
        alternatives=alternatives,
        mend=None if not step else {"steps": [{**step, "runs": list(runs)}]},
    )


def _stream(column: str | None) -> Literal["drive", "camera"] | None:
    if column is None:
        return None
    return "drive" if column.startswith(("drive", "voltage", "alpha")) else "camera"
