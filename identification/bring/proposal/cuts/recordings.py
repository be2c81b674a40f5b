"""Which logs are one recording: the drive's and the camera's, and pieces that go on."""

import dataclasses
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from identification.bring.proposal.look.words import CAMERA, tokens

STREAM_WORDS = CAMERA | frozenset(
    [
        "drive",
        "drives",
        "controller",
        "control",
        "ctrl",
        "log",
        "logs",
        "logged",
        "data",
        "daten",
        "rig",
        "messung",
        "measurement",
        "recording",
        "rec",
        "file",
        "csv",
        "txt",
        "mat",
        "tdms",
        "labview",
        "simulink",
        "scope",
        "scopedata",
        "acc",
        "accel",
        "imu",
        "phone",
        "accelerometer",
        "motor",
        "motors",
        "dyn",
    ]
)
"""Words of a file's name that say which stream it is, and nothing of the run."""
KIND_WORDS: Mapping[str, frozenset[str]] = {
    "pseudo_impulse": frozenset(
        ["knock", "knocks", "impulse", "impulses", "hammer", "tap", "hit", "schlag", "stoss"]
    ),
    "breakaway": frozenset(["breakaway", "break", "staircase", "losbrechen", "ramp"]),
    "manoeuvre": frozenset(
        ["manoeuvre", "manoeuver", "maneuver", "move", "moves", "leg", "legs", "traj", "fahrt"]
    ),
    "motor_step": frozenset(["bare", "uncoupled"]),
    "torque_step": frozenset(["torque", "step", "steps", "sprung", "openloop"]),
}
"""Words of a file's name that say a kind."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Recording:
    """Logs of one stretch of time."""

    drive: tuple[Path, ...]
    """The drive's logs, pieces in their order."""
    camera: tuple[Path, ...] = ()
    """The camera's."""
    accelerometer: tuple[Path, ...] = ()
    """The accelerometer's."""
    words: tuple[str, ...]
    """What their names say of the run."""

    @property
    def logs(self) -> dict[str, tuple[Path, ...]]:
        """The logs by stream."""
        return {
            "drive": self.drive,
            "camera": self.camera,
            "accelerometer": self.accelerometer,
        }

    @property
    def kind(self) -> str:
        """The kind that their names say, empty where they say none."""
        if {"motor", "step"} <= set(self.words) or "motorstep" in self.words:
            return "motor_step"
        told = set(self.words)
        return next((kind for kind, words in KIND_WORDS.items() if told & words), "")


def recordings(
    drive: Sequence[Path],
    camera: Sequence[Path],
    accelerometer: Sequence[Path],
    continues: Mapping[Path, Path],
) -> tuple[list[Recording], tuple[Path, ...]]:
    """Recordings of logs.

    Args:
        drive: The drive's logs.
        camera: The camera's; a log that holds both is in both.
        accelerometer: The accelerometer's.
        continues: Logs that go on where another ends, with that other.

    Returns:
        The recordings in the order of the drive's logs; and logs that belong to none.
    """
    keys = _keys([*drive, *camera, *accelerometer])
    begins = [path for path in drive if path not in continues]
    made = []
    for place, path in enumerate(begins):
        pieces = _chain(path, continues)
        partners = {
            name: _partner(path, place, begins, logs, keys, continues)
            for name, logs in (("camera", camera), ("accelerometer", accelerometer))
        }
        made.append(Recording(drive=pieces, words=keys[path], **partners))
    used = {p for each in made for p in (*each.drive, *each.camera, *each.accelerometer)}
    alone = tuple(p for p in dict.fromkeys((*camera, *accelerometer)) if p not in used)
    return made, alone


def _partner(
    path: Path,
    place: int,
    begins: Sequence[Path],
    logs: Sequence[Path],
    keys: Mapping[Path, tuple[str, ...]],
    continues: Mapping[Path, Path],
) -> tuple[Path, ...]:
    """The logs of another stream that go with a drive's log."""
    if path in logs:
        return _chain(path, continues)
    free = [log for log in logs if log not in begins and log not in continues]
    same = [log for log in free if keys[log] == keys[path]]
    if not same:
        numbers = [w for w in keys[path] if w.isdecimal()]
        same = [
            log
            for log in free
            if numbers and [w for w in keys[log] if w.isdecimal()] == numbers
        ]
    if len(same) == 1:
        return _chain(same[0], continues)
    others = [log for log in begins if log not in logs]
    if len(free) == len(others) and not same:
        return _chain(free[others.index(path)], continues)
    return ()


def _chain(path: Path, continues: Mapping[Path, Path]) -> tuple[Path, ...]:
    """A log with the pieces that go on from it."""
    after = {before: piece for piece, before in continues.items()}
    chain = [path]
    while chain[-1] in after:
        chain.append(after[chain[-1]])
    return tuple(chain)


def _keys(paths: Sequence[Path]) -> dict[Path, tuple[str, ...]]:
    """What each log's name, and its folder's, says beyond the stream and what all share."""
    words = {}
    for path in dict.fromkeys(paths):
        parts = tokens(path.resolve().parent.name) + tokens(re.sub(r"\.\w+$", "", path.name))
        # A motor step is a kind of run, a motor's log a stream.
        kind = {"motor"} if "step" in parts else set()
        words[path] = tuple(word for word in parts if word not in STREAM_WORDS - kind)
    shared = set.intersection(*map(set, words.values())) if len(words) > 1 else set()
    shared = {word for word in shared if not any(word in told for told in KIND_WORDS.values())}
    return {path: tuple(w for w in each if w not in shared) for path, each in words.items()}


def going_on(times: Mapping[Path, np.ndarray]) -> dict[Path, Path]:
    """Logs that begin where another ends, a sample later.

    Args:
        times: Time of each log's samples, of logs of one layout.

    Returns:
        Such logs with the one before.
    """
    found: dict[Path, Path] = {}
    for path, time in times.items():
        for other, before in times.items():
            step = float(np.median(np.diff(before)))
            # A log that begins at zero is a recording of its own, whatever else ends there.
            late = time[0] > 2.5 * step and len(time) > 2
            if path != other and late and abs(time[0] - before[-1] - step) < 0.6 * step:
                found[path] = other
    return found
