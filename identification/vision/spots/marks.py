"""The marks in the first pictures, and where the camera stands by them."""

import dataclasses
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float64

from identification.vision.lens import Lens, Marks, View, fit_plane
from identification.vision.lens.lateral import magnification
from identification.vision.settings.document import Mark, Marker, Vision
from identification.vision.settings.read import spot_name
from identification.vision.spots.colour import ColouredDisc
from identification.vision.spots.disc import Shape
from identification.vision.spots.look import Look, Picture, Sighting
from identification.vision.spots.tags import Tag, tag_size

MOST_RMS = 1.0
"""Marks that are further from where they are said to be are another rig [px]."""
STILL = np.zeros(2)
"""Path of what doesn't move [px]."""
_LEAST = 4
_BLURS = (0.6, 0.75, 0.9, 1.05, 1.25, 1.5, 1.8, 2.2)
_CLICK = 25.0
_TAG_RADIUS = 0.03


@dataclasses.dataclass(frozen=True)
class Start:
    """What the first picture with enough marks tells."""

    view: View
    """Where the camera stands."""
    blur: float
    """Standard deviation of the blur [px]."""
    tag_radius: float
    """Radius of a tag, half its diagonal [m]."""

    def shape(
        self,
        spot: Mark | Marker,
        place: Float64[np.ndarray, " 3"],
        travel: Float64[np.ndarray, " 2"] = STILL,
    ) -> Shape:
        """What a mark or marker looks like at a place.

        Args:
            spot: The mark or marker.
            place: Where it is, in the frame's coordinates [m].
            travel: Path during the exposure [px].

        Returns:
            Its shape.
        """
        radius = self.tag_radius if spot.diameter is None else spot.diameter / 2
        return Shape(self.view.footprint(place) * radius, self.blur, travel)


def look_of(vision: Vision, spot: Mark | Marker) -> Look:
    """What finds a mark or marker.

    Args:
        vision: What is said of the video.
        spot: The mark or marker.

    Returns:
        Its look.
    """
    if spot.aruco is not None:
        return Tag(spot.aruco, vision.dictionary)
    return ColouredDisc(vision.colours[spot.colour])


def colour_magnification(vision: Vision, spot: Mark | Marker, lateral: float) -> float:
    """How much more than grey a mark or marker is magnified.

    Args:
        vision: What is said of the video.
        spot: The mark or marker.
        lateral: How much more blue is magnified than red [1].

    Returns:
        The difference [1]; none for a tag, which is black and white.
    """
    if spot.colour is None:
        return 0.0
    return magnification(vision.colours[spot.colour], lateral)


def mark_places(vision: Vision) -> Float64[np.ndarray, "marks 3"]:
    """Where the marks are.

    Args:
        vision: What is said of the video.

    Returns:
        Their places in the frame's coordinates [m].
    """
    return np.array([[mark.x, mark.y, mark.z] for mark in vision.marks])


def mark_radii(vision: Vision) -> Float64[np.ndarray, " marks"]:
    """How large the marks are.

    Args:
        vision: What is said of the video.

    Returns:
        Radii of discs, 0 of tags [m].
    """
    return np.array([(mark.diameter or 0.0) / 2 for mark in vision.marks])


def first_view(vision: Vision, lens: Lens, picture: Picture) -> Start | None:
    """The camera's place by one picture.

    Args:
        vision: What is said of the video.
        lens: The lens.
        picture: The picture.

    Returns:
        The start; None where less than four marks are seen whole.
    """
    looks = [look_of(vision, mark) for mark in vision.marks]
    places, radii = mark_places(vision), mark_radii(vision)
    clicks = np.array(
        [_roughly(mark, look, picture) for mark, look in zip(vision.marks, looks, strict=True)]
    )
    seen = np.isfinite(clicks[:, 0])
    if np.count_nonzero(seen) < _LEAST:
        return None
    # A click is off by some pixels, and tells well enough how large a disc is.
    view = fit_plane(lens, places[seen], clicks[seen], 0 * radii[seen]).view
    start = Start(view, _BLURS[3], _tag_radius(vision, view, picture))
    for turn in range(2):
        sightings = _sightings(vision, start, looks, clicks, picture)
        whole = np.array([each is not None and each.is_whole for each in sightings])
        if np.count_nonzero(whole) < _LEAST:
            return None
        clicks = np.array(
            [
                click if each is None else each.centre
                for click, each in zip(clicks, sightings, strict=True)
            ]
        )
        fit = fit_plane(lens, places[whole], clicks[whole], radii[whole])
        start = dataclasses.replace(start, view=fit.view)
        if turn == 0:
            start = dataclasses.replace(
                start, blur=_blur(vision, start, looks, clicks, picture)
            )
    return start


def require_fit(vision: Vision, fit: Marks, kept: Sequence[int]) -> None:
    """Refuse marks that aren't where they are said to be.

    Args:
        vision: What is said of the video.
        fit: The fit.
        kept: Which marks it is of.

    Raises:
        ValueError: If they are more than 1 px off (rms), naming each.
    """
    if fit.rms <= MOST_RMS:
        return
    off = np.hypot(*fit.residual.T)
    names = [spot_name(vision, vision.marks[k]) for k in kept]
    order = np.argsort(-off)
    listing = ", ".join(f"{names[k]} {off[k]:.1f} px" for k in order)
    raise ValueError(
        f"marks: they are {fit.rms:.1f} px (rms) from where they are said to be, expected at "
        f"most {MOST_RMS:g} px: {listing}. Measure x and y of the first ones again, see "
        "whether `near` points at the right discs, and whether the photos of the board are of "
        "this lens."
    )


def _roughly(mark: Mark, look: Look, picture: Picture) -> Float64[np.ndarray, " 2"]:
    if mark.near is not None:
        return np.array(mark.near)
    found = look.places(picture, 0.0, np.inf)
    return found[0] if len(found) == 1 else np.full(2, np.nan)


def _sightings(
    vision: Vision,
    start: Start,
    looks: Sequence[Look],
    near: Float64[np.ndarray, "marks 2"],
    picture: Picture,
) -> list[Sighting | None]:
    pairs = zip(vision.marks, looks, mark_places(vision), near, strict=True)
    return [
        look.at(picture, at, start.shape(mark, place), _CLICK) if np.isfinite(at[0]) else None
        for mark, look, place, at in pairs
    ]


def _blur(
    vision: Vision,
    start: Start,
    looks: Sequence[Look],
    near: Float64[np.ndarray, "marks 2"],
    picture: Picture,
) -> float:
    """The blur that fits the marks best."""
    misfits = []
    for blur in _BLURS:
        tried = dataclasses.replace(start, blur=blur)
        seen = _sightings(vision, tried, looks, near, picture)
        misfits.append(np.median([each.misfit for each in seen if each is not None]))
    return _BLURS[int(np.argmin(misfits))]


def _tag_radius(vision: Vision, view: View, picture: Picture) -> float:
    """How large the tags are, by those that are seen; they are mostly printed alike."""
    sizes = []
    for spot in (*vision.marks, *vision.markers):
        if spot.aruco is None:
            continue
        seen = Tag(spot.aruco, vision.dictionary).places(picture, 0.0, np.inf)
        size = tag_size(vision.dictionary, spot.aruco, picture)
        if size is not None and len(seen) == 1:
            depth = spot.depth if isinstance(spot, Marker) else spot.z
            at = view.footprint(np.array([*view.places(seen[0], depth), depth]))
            sizes.append(size / np.sqrt(abs(np.linalg.det(at))))
    return float(np.median(sizes)) if sizes else _TAG_RADIUS
