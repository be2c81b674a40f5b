"""Marks and markers from picture to picture."""

import dataclasses
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float64

from identification.vision.pictures.stream import Frame
from identification.vision.settings.document import Vision
from identification.vision.spots.bodies import (
    FARTHEST,
    Candidate,
    assign,
    carriage_height,
    of_bodies,
    rigid_pose,
)
from identification.vision.spots.disc import Shape
from identification.vision.spots.look import Picture, Sighting
from identification.vision.spots.marks import STILL, Start, look_of, mark_places
from identification.vision.spots.trail import Trail

_STILL = 4.0  # levels: two pictures that differ by less in every block are alike
_MOVES = 3.0  # px: what is seen of a step for sure
_STRANGE_SCALE = 0.2  # a disc that is a fifth larger is another one
_STRANGE = 0.25  # misfit of what is no disc; discs have 0.02 to 0.1
_REACH = 5.0  # px: beyond a good prediction
_SPREAD = 0.6  # of a step: as much as it may change from one picture to the next
_LOST_SPREAD = 3.0  # px for each picture in which it was missed
_OTHER_TRAVEL = 0.5  # px: a path that is off by more is measured anew
_TURN = 0.12  # rad: what a body may turn between two sights of both its markers
_MOSTLY = 0.5  # share that is hidden where a place says nothing any more
_FASTEST = 3.0  # m/s
_CALM, _STEADY, _EVERY = 8, 0.1, 4  # pictures, px, pictures
_SMALLER, _LARGER, _FRAYED = 0.3, 2.5, 3.0  # of a disc's area, and px around it
_MISSING = np.full(2, np.nan)


@dataclasses.dataclass(frozen=True)
class Seen:
    """What was seen of marks or markers in one picture; NaN where nothing was."""

    pixel: Float64[np.ndarray, "spots 2"]
    """Centroids [px]."""
    scale: Float64[np.ndarray, " spots"]
    """Size over the expected one [1]."""
    hidden: Float64[np.ndarray, " spots"]
    """Share that is covered [1]."""
    misfit: Float64[np.ndarray, " spots"]
    """How much they are unlike their shape [1]."""
    variance: Float64[np.ndarray, "spots 2"]
    """Of their coordinates, by their own pictures [px²]."""


class Follower:
    """What follows marks and markers through a video."""

    def __init__(self, vision: Vision, start: Start):
        self.vision = vision
        self.start = start
        self.trails = [Trail() for _ in vision.markers]
        self.shift = np.zeros(2)
        self._shifts: list[Float64[np.ndarray, " 2"]] = []
        self._last: Seen | None = None
        bodies = [marker.body for marker in vision.markers]
        self._alone = [bodies.count(body) == 1 for body in bodies]
        self._apart: dict[tuple[int, int], Float64[np.ndarray, " 2"]] = {}
        self._scale = float(np.sqrt(abs(np.linalg.det(start.view.footprint(np.zeros(3))))))
        self._mark_looks = [look_of(vision, mark) for mark in vision.marks]
        self._looks = [look_of(vision, marker) for marker in vision.markers]
        places = mark_places(vision)
        self._mark_pixels = start.view.pixels(places)
        self._mark_shapes = [
            start.shape(mark, place) for mark, place in zip(vision.marks, places, strict=True)
        ]

    def marks(self, frame: Frame) -> Seen:
        """The marks in the next picture; a tripod that shakes moves them all.

        Args:
            frame: The picture.

        Returns:
            What is seen of them.
        """
        if self._is_steady() and frame.number % _EVERY:
            return _seen([None] * len(self._mark_looks))
        rows = zip(self._mark_looks, self._mark_pixels, self._mark_shapes, strict=True)
        seen = [
            look.at(frame.picture, pixel + self.shift, shape, 2 * _REACH)
            for look, pixel, shape in rows
        ]
        moved = [
            each.centre - pixel
            for each, pixel in zip(seen, self._mark_pixels, strict=True)
            if each is not None and each.is_whole
        ]
        if moved:
            self.shift = np.median(moved, axis=0)
            self._shifts = [*self._shifts[1 - _CALM :], self.shift]
        return _seen(seen)

    def _is_steady(self) -> bool:
        """Whether the marks have stood still: they needn't be looked at so often then."""
        calm = len(self._shifts) == _CALM
        return calm and bool(np.ptp(self._shifts, axis=0).max() < _STEADY)

    def markers(self, frame: Frame, time: float) -> Seen:
        """The markers in the next picture.

        Args:
            frame: The picture.
            time: When it was taken [s].

        Returns:
            What is seen of them.
        """
        if self._last is not None and self._stands(frame, time):
            return self._last
        seen: list[Sighting | None] = [None] * len(self.trails)
        for body, members in of_bodies(self.vision):
            for k in members:
                # One of several that look alike is taken for another after a while.
                sure = self._alone[k] or self.trails[k].missed < 2
                if self.trails[k].is_known and sure:
                    seen[k] = self._near(frame.picture, k, time)
            self._drop_strangers(body, members, seen)
            if all(seen[k] is None for k in members):
                self._find(frame.picture, body, members, seen)
            elif body == "end_effector":
                self._beside(frame.picture, members, seen)
        for k, trail in enumerate(self.trails):
            sighting = seen[k]
            if sighting is None or sighting.hidden > _MOSTLY:
                trail.missed += 1
            else:
                trail.moved_to(sighting.centre, time)
        self._last = _seen(seen)
        return self._last

    def _stands(self, frame: Frame, time: float) -> bool:
        """Whether nothing moves in a picture though it should: it is the one before again."""
        if frame.change > _STILL:
            return False
        return any(
            np.hypot(*trail.velocity) * (time - trail.time) > _MOVES
            for trail in self.trails
            if trail.is_known and trail.missed == 0
        )

    def _near(self, picture: Picture, k: int, time: float) -> Sighting | None:
        """A marker where it is expected."""
        trail = self.trails[k]
        step = trail.velocity * (time - trail.time) if trail.missed <= 1 else np.zeros(2)
        near = trail.pixel + step
        travel = trail.velocity * self.vision.time.exposure
        shape = self._shape(k, near, travel)
        reach = _REACH + _SPREAD * float(np.hypot(*step)) + _LOST_SPREAD * trail.missed
        alone = self._alone[k]
        if alone and not np.isfinite(trail.mean_velocity[0]) and trail.time > 0:
            reach += _FASTEST * (time - trail.time) * self._scale

        def travel_at(pixel: Float64[np.ndarray, " 2"]) -> Float64[np.ndarray, " 2"]:
            return trail.velocities(pixel, time)[1] * self.vision.time.exposure

        # Its patch of colour tells how fast it goes well enough, if it was seen just before.
        told = travel_at if np.isfinite(trail.velocities(near, time)[0][0]) else None
        sighting = self._looks[k].at(picture, near, shape, reach, told)
        if sighting is None:
            return None
        travel = travel_at(sighting.centre)
        if np.abs(travel - sighting.travel).max() > _OTHER_TRAVEL:
            # It goes faster or slower than it was expected to, so its blur is another.
            shape = dataclasses.replace(shape, travel=travel)
            again = self._looks[k].at(picture, sighting.centre, shape, _REACH)
            sighting = again or sighting
        return None if self._is_strange(sighting) else sighting

    def _shape(
        self,
        k: int,
        pixel: Float64[np.ndarray, " 2"],
        travel: Float64[np.ndarray, " 2"] = STILL,
    ) -> Shape:
        marker = self.vision.markers[k]
        place = self.start.view.places(pixel, marker.depth)
        return self.start.shape(marker, np.array([*place, marker.depth]), travel)

    @staticmethod
    def _is_strange(sighting: Sighting) -> bool:
        """Whether something is no such disc; one that is partly hidden still is one."""
        return sighting.misfit > _STRANGE or (
            sighting.is_whole and abs(sighting.scale - 1) > _STRANGE_SCALE
        )

    def _drop_strangers(
        self, body: str, members: Sequence[int], seen: list[Sighting | None]
    ) -> None:
        """Forget markers that can't be on their body."""
        there = [k for k in members if seen[k] is not None and seen[k].is_whole]
        places = self._places([seen[k].centre for k in there], there)
        if body == "lower_carriage":
            for k, place in zip(there, places, strict=True):
                if abs(place[1] - carriage_height(self.vision, self.vision.markers[k])) > 0.1:
                    self._forget([k], seen)
        if len(there) > 1:
            at = np.array([[self.vision.markers[k].x, self.vision.markers[k].y] for k in there])
            if rigid_pose(at, places).residual.max() > 2 * FARTHEST:
                self._forget(there, seen)

    def _beside(
        self, picture: Picture, members: Sequence[int], seen: list[Sighting | None]
    ) -> None:
        """Look for markers that are lost beside those of their body that aren't."""
        there = [k for k in members if seen[k] is not None and seen[k].is_whole]
        for k in members:
            for j in there:
                if seen[k] is not None or (k, j) not in self._apart:
                    break
                near = seen[j].centre + self._apart[k, j]
                travel = self.trails[j].velocity * self.vision.time.exposure
                reach = _REACH + _TURN * float(np.hypot(*self._apart[k, j]))
                found = self._looks[k].at(picture, near, self._shape(k, near, travel), reach)
                if found is not None and found.is_whole and not self._is_strange(found):
                    seen[k] = found
                    self._begin(k)
        for k in there:
            for j in there:
                self._apart[k, j] = seen[k].centre - seen[j].centre

    def _begin(self, k: int) -> None:
        """A trail anew, but for one that was lost in this very picture: it tells a velocity."""
        if self.trails[k].missed > 0:
            self.trails[k] = Trail()

    def _forget(self, members: Sequence[int], seen: list[Sighting | None]) -> None:
        for k in members:
            seen[k] = None
            self.trails[k] = Trail()

    def _places(
        self, pixels: Sequence[Float64[np.ndarray, " 2"]], members: Sequence[int]
    ) -> Float64[np.ndarray, "markers 2"]:
        depth = np.array([self.vision.markers[k].depth for k in members])
        return self.start.view.places(np.reshape(np.array(pixels), (-1, 2)) - self.shift, depth)

    def _find(
        self, picture: Picture, body: str, members: Sequence[int], seen: list[Sighting | None]
    ) -> None:
        """Look for a body that is lost, in the whole picture."""
        found: dict[int, list[Candidate]] = {}
        for k in members:
            twin = next((j for j in found if self._alike(j, k)), None)
            found[k] = self._candidates(picture, k) if twin is None else found[twin]
        there = {k: candidates for k, candidates in found.items() if candidates}
        if len(there) < (2 if body == "end_effector" else 1):
            return
        for k, candidate in assign(self.vision, body, there).items():
            seen[k] = candidate.sighting
            self._begin(k)

    def _alike(self, first: int, second: int) -> bool:
        """Whether nothing in a picture tells two markers from each other."""
        one, other = self.vision.markers[first], self.vision.markers[second]
        same = (one.diameter, one.depth) == (other.diameter, other.depth)
        return same and self._looks[first] == self._looks[second]

    def _candidates(self, picture: Picture, k: int) -> list[Candidate]:
        middle = np.array(picture.shape[1::-1]) / 2
        radius = self._shape(k, middle).radius
        # Chroma of half of the pixels colours the ground around a disc, and so does its path.
        least, most = _SMALLER * np.pi * radius**2, _LARGER * np.pi * (radius + _FRAYED) ** 2
        candidates = []
        for pixel in self._looks[k].places(picture, least, most):
            sighting = self._looks[k].at(picture, pixel, self._shape(k, pixel), _REACH)
            if sighting is None or self._is_strange(sighting) or not sighting.is_whole:
                continue
            place = self._places([sighting.centre], [k])[0]
            unlike = abs(sighting.scale - 1) + sighting.misfit
            candidates.append(Candidate(sighting, place, unlike))
        return sorted(candidates, key=lambda each: each.unlike)


def _seen(sightings: Sequence[Sighting | None]) -> Seen:
    return Seen(
        np.array([_MISSING if each is None else each.centre for each in sightings]),
        np.array([np.nan if each is None else each.scale for each in sightings]),
        np.array([np.nan if each is None else each.hidden for each in sightings]),
        np.array([np.nan if each is None else each.misfit for each in sightings]),
        np.array([_MISSING if each is None else each.variance for each in sightings]),
    )
