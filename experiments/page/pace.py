"""How far a computation is, in time.

A computation tells which share of its work is done, and its parts aren't alike: compiling tells
nothing for seconds, and legs are told one by one. So what is told becomes a share of the time
by how it went the last time, or, the first time, by how it usually goes; and between two
tellings the share goes on as far as the next one: by the processor time that this process took
for that part the last time, or by the clock where it wasn't this process that worked. The share
that is told would be simpler, and stands still for seconds and leaps; so would the clock alone,
which is wrong as soon as others take the processor.
"""

import bisect
import dataclasses
import json
import math
import pathlib
from collections.abc import Sequence

from scdpr_jax.numerics.files import write_whole

_BELIEF = 0.2
"""Share of the whole that the last time counts for, beside what this one has shown [1]; a
quarter of it where that was on another machine, a twentieth where nothing is known."""
_NEARLY = 0.8
"""Share of the way to the next telling that goes by the clock; then it slows down [1]."""
_POINTS = 60
"""Points that are kept: a bar has no more parts."""


@dataclasses.dataclass(frozen=True)
class Pace:
    """How long a computation took, and when it had told what."""

    total: float
    """Its time [s]."""
    points: tuple[tuple[float, float], ...]
    """Shares that it told, and the share of the time at which it did, both rising."""
    used: tuple[float, ...] = ()
    """Processor time that it had taken at each of them and at its end [s]; empty: unknown."""

    def scaled(self, total: float) -> "Pace":
        """The same on a machine on which it takes another time.

        Args:
            total: The time [s].

        Returns:
            The pace.
        """
        return dataclasses.replace(self, total=total)


_BUSY = 0.5
"""A part's processor time over what it would be if it were spread evenly, from which on the
part is this process's own work [1]."""
_OWN = 0.1
"""Processor time over time below which others do the work [1]."""
_RECENT = 0.2
"""Share of the whole whose pace, the last one seen, counts as much as that of all [1]."""
_FINE = 0.005
"""Steps in which the way is kept [1]."""
EVEN = Pace(60.0, ())
"""Of what has never been run: what it tells is taken for its time, of a minute."""
_UNKNOWN = 0.1
"""How far the clock alone may go where nothing is known of what comes [1]."""


@dataclasses.dataclass(frozen=True)
class Standing:
    """How far a computation is."""

    share: float
    """Share of the time that has passed [1]."""
    left: float
    """Time left [s]; not a number where it can't be told yet."""


class Clock:
    """What a computation tells, as time: the share never falls, and goes on by itself."""

    def __init__(self, pace: Pace, now: float, used: float = 0.0):
        """A clock at the begin of a computation.

        Args:
            pace: How it went before.
            now: Time [s], on any clock.
            used: Processor time of the process [s].
        """
        self._pace = pace
        self._begin = now
        self._used = used
        self._told = [(0.0, 0.0, 0.0)]
        self._way = [(0.0, 0.0)]
        self._at = 0.0
        self._shown = 0.0

    def tell(self, share: float, now: float, used: float = 0.0) -> None:
        """Take what is told; a share below what was told before counts as that.

        Args:
            share: Share of the work that is done [1].
            now: Time [s].
            used: Processor time of the process [s].
        """
        if share <= self._told[-1][0]:
            return  # Other words, and nothing of how far it is.
        self._told.append((share, now - self._begin, used - self._used))
        self._at = max(self._at, self._in_time(share))

    def standing(self, now: float, used: float = 0.0) -> Standing:
        """How far it is.

        Args:
            now: Time [s].
            used: Processor time of the process [s].

        Returns:
            Where it stands.
        """
        passed, (_, told, taken) = now - self._begin, self._told[-1]
        total = self._total(self._at, told)
        ahead = self._next(self._at) - self._at
        if not self._pace.points:
            ahead = min(ahead, _UNKNOWN)
        gone, work = (passed - told) / total, self._work(self._at, ahead)
        if work:
            gone = ahead * (used - self._used - taken) / work
        share = self._at + (ahead * _creeping(gone / ahead) if ahead else 0.0)
        self._shown = min(max(self._shown, share), 1.0)
        known = self._told[-1][0] or self._pace.points
        if not known or not share:
            return Standing(self._shown, math.nan)
        # What takes longer than it ever did makes the whole longer; a bar that ran ahead of
        # what was told then waits, and the time left doesn't.
        longer = max(total, passed / share)
        total = self._total(share, passed) if work else longer
        if self._pace.used:
            total = (total + self._recent(share, passed, total)) / 2
        return Standing(self._shown, total * (1 - min(share, 1.0)))

    def pace(self, now: float, used: float = 0.0) -> Pace:
        """How it went.

        Args:
            now: Time of its end [s].
            used: Processor time of the process [s].

        Returns:
            The pace, for the next time.
        """
        total = max(now - self._begin, 1e-9)
        points: list[tuple[float, float, float]] = []
        for share, at, taken in self._told[1:]:
            # What is told at once after something else is where that part ended.
            if not points or (share > points[-1][0] and at / total > points[-1][1]):
                points.append((share, at / total, taken))
        every = max(1, -(-len(points) // _POINTS))
        kept = points[::every]
        took = (*(taken for _, _, taken in kept), used - self._used)
        return Pace(total, tuple(point[:2] for point in kept), took if used else ())

    def _in_time(self, share: float) -> float:
        """A share of the work as a share of the time."""
        return _between(share, *self._curve())

    def _next(self, at: float) -> float:
        """Share of the time at which something is told next."""
        return next((time for time in self._curve()[1] if time > at), 1.0)

    def _curve(self) -> tuple[Sequence[float], Sequence[float]]:
        inner = [point for point in self._pace.points if 0 < point[0] < 1 and 0 < point[1] < 1]
        shares, times = zip((0.0, 0.0), *inner, (1.0, 1.0), strict=True)
        return shares, times

    def _recent(self, share: float, passed: float, total: float) -> float:
        """Time of a whole that goes as the last part of the way did [s]."""
        if share > self._way[-1][0] + _FINE:
            self._way.append((share, passed))
        ways = (own for own in reversed(self._way) if own[0] <= share - _RECENT)
        before, then = next(ways, self._way[0])
        return (passed - then) / (share - before) if share > before else total

    def _work(self, at: float, ahead: float) -> float:
        """Processor time of a part that begins at some share [s]; 0 where others work."""
        if not ahead or sum(self._pace.used[-1:]) <= _OWN * self._pace.total:
            return 0.0
        times = (0.0, *(time for _, time in self._pace.points), 1.0)
        used = (0.0, *self._pace.used)
        begin, end = (_between(time, times, used) for time in (at, at + ahead))
        return end - begin if end - begin > _BUSY * ahead * used[-1] else 0.0

    def _total(self, share: float, passed: float) -> float:
        """Time of the whole [s], by the last time and by how far it was after some time."""
        # Of what has never been run here, what it shows itself counts nearly alone.
        belief = _BELIEF if self._pace.used else _BELIEF / (4 if self._pace.points else 20)
        return (passed + belief * self._pace.total) / (share + belief)


def _between(at: float, places: Sequence[float], values: Sequence[float]) -> float:
    """A value between those at rising places."""
    above = min(max(bisect.bisect_right(places, at), 1), len(places) - 1)
    low, high = places[above - 1], places[above]
    part = (at - low) / (high - low) if high > low else 1.0
    return values[above - 1] + part * (values[above] - values[above - 1])


def _creeping(gone: float) -> float:
    """Share of the way to the next telling for a share of its time, which may take longer."""
    late = max(gone - _NEARLY, 0.0)
    return min(gone, _NEARLY) - (1 - _NEARLY) * math.expm1(-late / (1 - _NEARLY))


def expected(name: str, kept: pathlib.Path | None) -> Pace:
    """How a computation will go: as the last time, or as it usually goes.

    The first time on a machine compiles, and the second doesn't: the first is no measure for
    the second but for the machine's speed.

    Args:
        name: Its name.
        kept: Where paces are kept; None where nowhere.

    Returns:
        The pace.
    """
    last = _kept(kept).get(name)
    first, again = USUAL.get(name, (EVEN, EVEN))
    if last is None:
        return first
    if name in USUAL and not last.points:
        return again.scaled(again.total * last.total / first.total)
    return last


def keep(name: str, pace: Pace, kept: pathlib.Path | None) -> None:
    """Keep how a computation went, for the next time.

    Args:
        name: Its name.
        pace: How it went; of the first time on a machine its time alone is kept.
        kept: Where paces are kept; None where nowhere.
    """
    if kept is None:
        return
    every = _kept(kept)
    first = name in USUAL and name not in every
    every[name] = dataclasses.replace(pace, points=(), used=()) if first else pace
    document = {known: dataclasses.asdict(own) for known, own in every.items()}
    try:
        write_whole(kept, json.dumps(document))
    except OSError:
        return  # A bar that knows less the next time is no reason to fail.


def _kept(file: pathlib.Path | None) -> dict[str, Pace]:
    """What is kept; nothing where it can't be read, or isn't what was written."""
    if file is None or not file.exists():
        return {}
    try:
        document = json.loads(file.read_text(encoding="utf-8"))
        return {
            name: Pace(
                float(own["total"]),
                tuple((float(a), float(b)) for a, b in own["points"]),
                tuple(map(float, own["used"])),
            )
            for name, own in document.items()
            if len(own["used"]) in (0, len(own["points"]) + 1)
        }
    except (OSError, ValueError, TypeError, KeyError, AttributeError):
        return {}


def _usual(total: float, *points: tuple[float, float]) -> Pace:
    return Pace(total, points)


USUAL: dict[str, tuple[Pace, Pace]] = {
    "calibrate": (
        _usual(
            90.0,
            (0.1, 0.2),
            (0.65, 0.21),
            (0.7, 0.24),
            (0.83, 0.32),
            (0.846, 0.4),
            (0.862, 0.66),
            (0.874, 0.73),
            (0.93, 0.85),
        ),
        _usual(
            25.0,
            (0.1, 0.06),
            (0.65, 0.11),
            (0.7, 0.18),
            (0.83, 0.36),
            (0.846, 0.47),
            (0.862, 0.66),
            (0.874, 0.82),
            (0.93, 0.845),
        ),
    ),
    "identify": (
        _usual(60.0, (0.13, 0.87), (0.4, 0.89)),
        _usual(4.0, (0.13, 0.42), (0.4, 0.56)),
    ),
    "tune": (
        _usual(60.0, (0.1, 0.27), (0.7, 0.34), (0.8, 0.45), (0.89, 0.8), (0.95, 0.91)),
        _usual(13.0, (0.1, 0.06), (0.7, 0.21), (0.8, 0.37), (0.89, 0.63), (0.95, 0.97)),
    ),
    "plan": (
        _usual(40.0, (0.12, 0.36), (0.54, 0.69), (0.6, 0.77)),
        _usual(3.0, (0.12, 0.36), (0.54, 0.69), (0.6, 0.77)),
    ),
    "plan --legs": (_usual(57.0, (0.75, 0.89)), _usual(5.0, (0.75, 0.75))),
}
"""How a verb goes the first time on a machine, which compiles, and again, by its name: measured
on a campaign of 14 runs."""
