"""How far a computation is, in time.

A computation tells which share of its work is done, and its parts aren't alike: compiling tells
nothing for seconds, and legs are told one by one. So what is told becomes a share of the time
by how it went before, or, the first time, by how it usually goes; and between two tellings the
share goes on by the clock, as far as the next one. The time left follows from the share and
from the time that has passed. The share that is told would be simpler, and stands still for
seconds and leaps; so would the clock alone, which is wrong as soon as others take the
processor.

Some work shows up on the way only: whether models have to be compared is known once the usual
one is fitted, and most campaigns go past it. It is a detour: its time counts from the first
that is told of it. A mean of both ways would be wrong for either.
"""

import bisect
import dataclasses
import math
from collections.abc import Sequence

_NEARLY = 0.8
"""Share of the way to the next telling that goes by the clock; then it slows down [1]."""
_POINTS = 60
"""Points that are kept: a bar has no more parts."""
_SAME = 0.01
"""Shares of the time that are one: what is told now is seldom told to the last digit [1]."""
_LAST = 0.99
"""The most that is told [1]: what is done after the last telling takes its time as well."""
_UNKNOWN = 0.1
"""How far the clock alone may go where nothing is known of what comes [1]."""
BEGUN = 1e-9
"""Share that counts as told where the first thing to be done begins: what came before it took
its time as well [1]."""


@dataclasses.dataclass(frozen=True)
class Pace:
    """How long a computation takes, and when it tells what."""

    total: float
    """Its time [s]."""
    points: tuple[tuple[float, float], ...]
    """Shares that it tells, and the share of the time at which it does, both rising."""
    belief: float = 0.2
    """Share of the whole that the time counts for, beside what this call has shown [1]."""
    origin: float = 0.0
    """Share that is told where its time begins [1]: 0 but of a detour, whose time alone this
    is, whatever was before."""
    detour: "Detour | None" = None
    """Work that some calls have on the way; None where there is none, or where the points have
    it."""

    @property
    def curve(self) -> tuple[Sequence[float], Sequence[float]]:
        """Shares of the work and of the time, from the begin to the end."""
        inner = [point for point in self.points if self.origin < point[0] < 1 > point[1] > 0]
        shares, times = zip((self.origin, 0.0), *inner, (1.0, 1.0), strict=True)
        return shares, times

    def scaled(self, total: float) -> "Pace":
        """The same on a machine on which it takes another time.

        Args:
            total: The time [s].

        Returns:
            The pace.
        """
        return dataclasses.replace(self, total=total)

    def with_detour(self, detour: "Detour | None") -> "Pace":
        """The same with work that some calls have on the way.

        Args:
            detour: The work; None for none.

        Returns:
            The pace, unchanged where its points have that work.
        """
        if detour is not None and detour.taken(self):
            return self
        return dataclasses.replace(self, detour=detour)

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


@dataclasses.dataclass(frozen=True)
class Detour:
    """Work that only some calls have, told between two shares that the others go past."""

    begin: float
    """The last share before it [1]."""
    end: float
    """The first share after it [1]."""
    pace: Pace
    """How such a call goes."""

    def holds(self, share: float) -> bool:
        """Whether what is told is within.

        Args:
            share: What is told [1].

        Returns:
            Whether it is.
        """
        return self.begin < share < self.end

    def taken(self, pace: Pace) -> bool:
        """Whether a call had this work.

        Args:
            pace: How it went.

        Returns:
            Whether it told anything of it.
        """
        return any(self.holds(share) for share, _ in pace.points)


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
        self._origin = 0.0  # of the pace's time, as the tellings' from the begin
        self._turn = (0.0, 0.0)  # shares, of the bar and of the pace, where the pace came in
        self._told = [(0.0, 0.0)]
        self._at = 0.0
        self._shown = 0.0

    def tell(self, share: float, now: float) -> None:
        """Take what is told; a share below what was told before counts as that.

        Args:
            share: Share of the work that is done [1].
            now: Time [s].
        """
        share = min(max(share, BEGUN), _LAST)
        if share <= self._told[-1][0]:
            return  # Other words, and nothing of how far it is.
        detour = self._pace.detour
        if detour is not None and detour.holds(share):
            self._take(detour, now)
        self._told.append((share, now - self._begin))
        self._at = max(self._at, _between(share, *self._pace.curve))

    def standing(self, now: float) -> Standing:
        """How far it is.

        Args:
            now: Time [s].

        Returns:
            Where it stands.
        """
        passed = now - self._begin - self._origin
        told = self._told[-1][1] - self._origin
        ahead = self._next() - self._at
        if not self._pace.points:
            ahead = min(ahead, _UNKNOWN)
        share = self._at
        if ahead:
            share += ahead * _creeping((passed - told) / self._total(self._at, told) / ahead)
        bar, begin = self._turn
        shown = bar + (1 - bar) * (share - begin) / (1 - begin)
        self._shown = min(max(self._shown, shown), 1.0)
        known = self._told[-1][0] > BEGUN or self._pace.points
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

    def _take(self, detour: Detour, now: float) -> None:
        """Go on by the pace of a detour, the bar from where it is."""
        bar = self.standing(now).share
        share, told = self._told[-1]
        self._pace = detour.pace
        self._at = _between(share, *self._pace.curve) if share > self._pace.origin else 0.0
        self._origin = told if self._pace.origin else 0.0
        self._turn = (min(bar, 1 - BEGUN), self._at)

    def _next(self) -> float:
        """Share of the time at which something is told next."""
        after = self._at + _SAME
        return next((time for time in self._pace.curve[1] if time > after), 1.0)

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
