"""Which disc is which marker, by the bodies that they are on."""

import dataclasses
import itertools
from collections.abc import Iterator, Sequence

import numpy as np
from jaxtyping import Float64

from identification.vision.settings.document import Marker, Vision
from identification.vision.spots.look import Sighting
from scdpr_jax.robot.stated.numbers import PROVENANCE

FARTHEST = 3e-3
"""Markers of a rigid body that are further from where they should be aren't its [m]."""
_MOST_TURNED = 1.0
_MOST_TRIED = 8
_OFF_GUIDE = 0.06
_TIE = 0.1


@dataclasses.dataclass(frozen=True)
class Pose:
    """A rigid body in the plane."""

    place: Float64[np.ndarray, " 2"]
    """Its origin [m]."""
    angle: float
    """How far it is turned, counter-clockwise [rad]."""
    residual: Float64[np.ndarray, " markers"]
    """How far each marker is from where it should be [m]."""


def rigid_pose(
    body: Float64[np.ndarray, "markers 2"], seen: Float64[np.ndarray, "markers 2"]
) -> Pose:
    """The pose that brings a body's markers closest to where they are seen.

    Args:
        body: Markers from the body's origin, two at least [m].
        seen: Where they are seen [m].

    Returns:
        The least-squares pose, in closed form.
    """
    middle, centre = body.mean(axis=0), seen.mean(axis=0)
    a, b = body - middle, seen - centre
    angle = np.arctan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), (a * b).sum())
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    place = centre - turn @ middle
    return Pose(place, float(angle), np.hypot(*(seen - place - body @ turn.T).T))


def frame_height(vision: Vision) -> float:
    """Height of the upper guide.

    Args:
        vision: What is said of the video.

    Returns:
        It as stated, or the prototype's [m].
    """
    if vision.frame_height is not None:
        return vision.frame_height
    return next(each.consistent for each in PROVENANCE if each.name == "frame_height")


def carriage_height(vision: Vision, marker: Marker) -> float:
    """Height at which a carriage's marker runs.

    Args:
        vision: What is said of the video.
        marker: The marker.

    Returns:
        Its height [m].
    """
    return marker.y + (frame_height(vision) if marker.body == "upper_carriage" else 0.0)


@dataclasses.dataclass(frozen=True)
class Candidate:
    """A disc that may be a marker."""

    sighting: Sighting
    """How it is seen."""
    place: Float64[np.ndarray, " 2"]
    """Where that is [m]."""
    unlike: float
    """How much its shape is unlike the marker's [1]."""


def assign(
    vision: Vision, body: str, found: dict[int, list[Candidate]]
) -> dict[int, Candidate]:
    """Which candidates are a body's markers.

    Markers of a rigid body have known distances, and a carriage runs along its guide: what
    agrees with that is taken. Where two ways agree equally well, none is.

    Args:
        vision: What is said of the video.
        body: The body.
        found: Candidates for each of its markers, by its place among the markers.

    Returns:
        The candidate of each marker; empty if none is sure.
    """
    best = [each[:_MOST_TRIED] for each in found.values()]
    markers = [vision.markers[k] for k in found]
    ways = []
    for chosen in itertools.product(*best):
        if len({id(each) for each in chosen}) == len(chosen):
            cost = _cost(vision, body, markers, chosen)
            if cost is not None:
                ways.append((cost, chosen))
    ways.sort(key=lambda way: way[0])
    if not ways or (len(ways) > 1 and ways[1][0] - ways[0][0] < _TIE):
        return {}
    return dict(zip(found, ways[0][1], strict=True))


def _cost(
    vision: Vision, body: str, markers: Sequence[Marker], chosen: Sequence[Candidate]
) -> float | None:
    """How unlikely a choice is; None if it can't be."""
    seen = np.array([each.place for each in chosen])
    cost = sum(each.unlike for each in chosen)
    if body != "end_effector":
        off = [
            abs(place[1] - carriage_height(vision, marker))
            for marker, place in zip(markers, seen, strict=True)
        ]
        sure = body == "lower_carriage" or vision.frame_height is not None
        if sure and max(off) > _OFF_GUIDE:
            return None
        cost += max(off) / _OFF_GUIDE
    if len(markers) > 1:
        pose = rigid_pose(np.array([[m.x, m.y] for m in markers]), seen)
        if pose.residual.max() > FARTHEST or abs(pose.angle) > _MOST_TURNED:
            return None
        cost += pose.residual.max() / FARTHEST + abs(pose.angle)
    return cost


def of_bodies(vision: Vision) -> Iterator[tuple[str, list[int]]]:
    """The bodies that have markers.

    Args:
        vision: What is said of the video.

    Yields:
        A body and the places of its markers among all.
    """
    for body in dict.fromkeys(marker.body for marker in vision.markers):
        yield body, [k for k, marker in enumerate(vision.markers) if marker.body == body]
