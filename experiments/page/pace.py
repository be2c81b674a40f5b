"""How far a computation is, in time.

A computation tells which share of its work is done, and its parts aren't alike: compiling tells
nothing for seconds, and legs are told one by one. So what is told becomes a share of the time
by how it went before, or, the first time, by how it usually goes; and between two tellings the
share goes on by the clock, as far as the next one. The time left follows from the share and
from the time that has passed. The share that is told would be simpler, and stands still for
seconds and leaps; so would the clock alone, which is wrong as soon as others take the
processor.
"""

import bisect
import dataclasses
import json
import math
import pathlib
from collections.abc import Sequence

from scdpr_jax.numerics.files import write_whole

_NEARLY = 0.8
"""Share of the way to the next telling that goes by the clock; then it slows down [1]."""
_POINTS = 60
"""Points that are kept: a bar has no more parts."""
_UNKNOWN = 0.1
"""How far the clock alone may go where nothing is known of what comes [1]."""
_BEGUN = 1e-9
"""Share that counts as told where the first thing to be done begins: what came before it took
its time as well [1]."""
_KEPT = 50
"""Paces that are kept, the last ones."""


@dataclasses.dataclass(frozen=True)
class Pace:
    """How long a computation takes, and when it tells what."""

    total: float
    """Its time [s]."""
    points: tuple[tuple[float, float], ...]
    """Shares that it tells, and the share of the time at which it does, both rising."""
    belief: float = 0.2
    """Share of the whole that the time counts for, beside what this call has shown [1]."""

    @property
    def curve(self) -> tuple[Sequence[float], Sequence[float]]:
        """Shares of the work and of the time, from the begin to the end."""
        inner = [point for point in self.points if 0 < point[0] < 1 and 0 < point[1] < 1]
        shares, times = zip((0.0, 0.0), *inner, (1.0, 1.0), strict=True)
        return shares, times

    def scaled(self, total: float) -> "Pace":
        """The same on a machine on which it takes another time.

        Args:
            total: The time [s].

        Returns:
            The pace.
        """
        return dataclasses.replace(self, total=total)

    def after(self, last: "Pace") -> "Pace":
        """What to expect after this call, and others before it.

        Where a call waits for others on the machine, another call won't: each moment is the
        mean of this one's and of those before, which count half as much with every call.

        Args:
            last: What was expected before.

        Returns:
            The pace: the time of this call, its moments moved half-way to those.
        """
        moments: list[tuple[float, float]] = []
        for share, time in self.points:
            moment = (time + _between(share, *last.curve)) / 2
            if not moments or moment > moments[-1][1]:
                moments.append((share, moment))
        return Pace(self.total, tuple(moments))


EVEN = Pace(60.0, (), belief=0.01)
"""Of what has never been run: what it tells is taken for its time, of a minute."""


@dataclasses.dataclass(frozen=True)
class Standing:
    """How far a computation is."""

    share: float
    """Share of the time that has passed [1]."""
    left: float
    """Time left [s]; not a number where it can't be told yet."""


class Clock:
    """What a computation tells, as time: the share never falls, and goes on by itself."""

    def __init__(self, pace: Pace, now: float):
        """A clock at the begin of a computation.

        Args:
            pace: How it went before.
            now: Time [s], on any clock.
        """
        self._pace = pace
        self._begin = now
        self._told = [(0.0, 0.0)]
        self._at = 0.0
        self._shown = 0.0

    def tell(self, share: float, now: float) -> None:
        """Take what is told; a share below what was told before counts as that.

        Args:
            share: Share of the work that is done [1].
            now: Time [s].
        """
        share = max(share, _BEGUN)
        if share <= self._told[-1][0]:
            return  # Other words, and nothing of how far it is.
        self._told.append((share, now - self._begin))
        self._at = max(self._at, _between(share, *self._pace.curve))

    def standing(self, now: float) -> Standing:
        """How far it is.

        Args:
            now: Time [s].

        Returns:
            Where it stands.
        """
        passed, (_, told) = now - self._begin, self._told[-1]
        ahead = self._next() - self._at
        if not self._pace.points:
            ahead = min(ahead, _UNKNOWN)
        share = self._at
        if ahead:
            share += ahead * _creeping((passed - told) / self._total(self._at, told) / ahead)
        self._shown = min(max(self._shown, share), 1.0)
        known = self._told[-1][0] > _BEGUN or self._pace.points
        left = self._total(share, passed) * (1 - share) if known and share else math.nan
        return Standing(self._shown, left)

    def pace(self, now: float) -> Pace:
        """How it went.

        Args:
            now: Time of its end [s].

        Returns:
            The pace, for the next time.
        """
        total = max(now - self._begin, 1e-9)
        points: list[tuple[float, float]] = []
        for share, at in self._told[1:]:
            # What is told at once after something else is where that part ended.
            if not points or at / total > points[-1][1]:
                points.append((share, at / total))
        return Pace(total, tuple(points[:: max(1, -(-len(points) // _POINTS))]))

    def _next(self) -> float:
        """Share of the time at which something is told next."""
        return next((time for time in self._pace.curve[1] if time > self._at), 1.0)

    def _total(self, share: float, passed: float) -> float:
        """Time of the whole [s], by the last time and by how far it was after some time."""
        belief = self._pace.belief
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


def expected(name: str, kept: pathlib.Path | None, *, given: str = "") -> Pace:
    """How a computation will go: as with this input, as the last time, or as it usually goes.

    Args:
        name: Its name.
        kept: Where paces are kept; None where nowhere.
        given: What it is given, by a name that lasts.

    Returns:
        The pace.
    """
    every = _kept(kept)
    last = every.get(f"{name} {given}".rstrip(), every.get(name))
    if last is not None:
        return last
    first, again = USUAL.get(name, (EVEN, EVEN))
    return first if _compiles(name, every) else again


def _compiles(name: str, every: dict[str, Pace]) -> bool:
    """Whether nothing is known to have compiled what it runs."""
    return {name, *_THE_WHOLE}.isdisjoint(every)


def keep(name: str, pace: Pace, kept: pathlib.Path | None, *, given: str = "") -> None:
    """Keep how a computation went, for the next time.

    The first time on a machine compiles, and the second doesn't: the first is no measure for
    the second but for the machine's speed.

    Args:
        name: Its name.
        pace: How it went.
        kept: Where paces are kept; None where nowhere.
        given: What it was given, by a name that lasts.
    """
    if kept is None:
        return
    every = _kept(kept)
    own = f"{name} {given}".rstrip()
    if name in USUAL and _compiles(name, every):
        first, again = USUAL[name]
        every[name] = again.scaled(again.total * pace.total / first.total)
    else:
        # Another input may take ten times as long: it goes as is usual, where that is known.
        for known in {own, name} - (USUAL.keys() - {own}):
            every[known] = pace.after(every.pop(known)) if known in every else pace
    last = list(every.items())[-_KEPT:]
    document = {known: [each.total, each.points] for known, each in last}
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
            name: Pace(float(total), tuple((float(a), float(b)) for a, b in points))
            for name, (total, points) in document.items()
            if total > 0
        }
    except (OSError, ValueError, TypeError, AttributeError):
        return {}


def _usual(total: float, *points: tuple[float, float]) -> Pace:
    return Pace(total, points, belief=0.05)


_THE_WHOLE = ("calibrate", "demo")
"""What compiles all that the verbs of `USUAL` run."""


USUAL: dict[str, tuple[Pace, Pace]] = {
    "calibrate": (
        _usual(
            60.0,
            (0.019, 0.07),
            (0.1, 0.38),
            (0.65, 0.43),
            (0.7, 0.44),
            (0.738, 0.52),
            (0.828, 0.57),
            (0.846, 0.64),
            (0.862, 0.77),
            (0.874, 0.8),
            (0.93, 0.87),
            (0.958, 0.95),
        ),
        _usual(
            16.0,
            (0.019, 0.05),
            (0.1, 0.1),
            (0.65, 0.13),
            (0.7, 0.14),
            (0.738, 0.27),
            (0.783, 0.34),
            (0.828, 0.4),
            (0.846, 0.57),
            (0.862, 0.62),
            (0.866, 0.67),
            (0.874, 0.76),
            (0.93, 0.8),
            (0.937, 0.86),
            (0.972, 0.96),
        ),
    ),
    "identify": (
        _usual(60.0, (_BEGUN, 0.1), (0.12, 0.5), (0.29, 0.55), (0.4, 0.62), (0.85, 0.9)),
        _usual(6.0, (_BEGUN, 0.08), (0.12, 0.16), (0.29, 0.28), (0.4, 0.35), (0.85, 0.8)),
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
on campaigns of 14 runs."""
