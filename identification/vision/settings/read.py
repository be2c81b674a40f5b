"""Reading a `VISION.toml` and holding its parts against each other."""

import dataclasses
from collections.abc import Iterator
from pathlib import Path

from pydantic import ValidationError

from identification.campaign.faults import Fault
from identification.campaign.tables.document import read_document
from identification.vision.settings.document import Marker, Vision
from identification.vision.settings.faults import VisionError, document_faults

_LEAST_MARKS = 4


def read_vision(path: Path) -> Vision:
    """What is said of a video.

    Args:
        path: The file.

    Returns:
        It, in SI units and radians; the files that it names are relative to its folder.

    Raises:
        VisionError: If anything in it isn't as it should be, with all that is wrong.
    """
    document, text, fault = read_document(path)
    if fault is not None:
        raise VisionError(path, [dataclasses.replace(fault, file=path.name)])
    try:
        vision = Vision.model_validate(document)
    except ValidationError as error:
        raise VisionError(
            path, list(document_faults(error, Vision, text, file=path.name))
        ) from None
    faults = [dataclasses.replace(each, file=path.name) for each in _contradictions(vision)]
    if faults:
        raise VisionError(path, faults)
    return vision


def spot_name(vision: Vision, spot: object) -> str:
    """What a mark or marker is called in a message.

    Args:
        vision: What is said of the video.
        spot: One of its marks or markers.

    Returns:
        Its own name, or its body or kind with its number.
    """
    for kind, spots in (("mark", vision.marks), ("marker", vision.markers)):
        for number, each in enumerate(spots, start=1):
            if each is spot:
                body = f" ({each.body})" if isinstance(each, Marker) else ""
                return each.name or f"{kind} {number}{body}"
    raise ValueError("the spot must be one of the video's marks or markers. Give one of them.")


def _contradictions(vision: Vision) -> Iterator[Fault]:
    if len(vision.marks) < _LEAST_MARKS:
        yield Fault(
            what="too few marks",
            key="marks",
            got=str(len(vision.marks)),
            expected=f"at least {_LEAST_MARKS}, not all on a line",
            remedy="Put more of them on the frame and measure where they are.",
        )
    for kind in ("marks", "markers"):
        for number, spot in enumerate(getattr(vision, kind), start=1):
            if spot.colour is not None and spot.colour not in vision.colours:
                yield Fault(
                    what="a colour that isn't described",
                    key=f"{kind} {number}.colour",
                    got=repr(spot.colour),
                    expected=f"one of {', '.join(vision.colours) or 'none: there is none'}",
                    remedy=f"Add a table [colours.{spot.colour}], or `colours.{spot.colour} = "
                    f'"{spot.colour}"` above the first table.',
                )
            if kind == "marks" and spot.colour is not None and spot.near is None:
                yield Fault(
                    what="a mark that could be any of its colour",
                    key=f"{kind} {number}.near",
                    got="no such key",
                    expected="near = [154, 962], its pixel, roughly",
                    remedy="Read it off a picture; `scdpr track VIDEO --propose` finds it.",
                )
    yield from _body_faults(vision)
    yield from _tag_faults(vision)


def _body_faults(vision: Vision) -> Iterator[Fault]:
    bodies = [marker.body for marker in vision.markers]
    if bodies.count("end_effector") == 1:
        yield Fault(
            what="one marker can't tell how the end-effector is turned",
            key="markers",
            got="1 on end_effector",
            expected="two at least",
            remedy="Put a second one on it, as far from the first as there is room.",
        )
    if not bodies:
        yield Fault(
            what="no markers",
            key="markers",
            got="none",
            expected="two on end_effector, one on each carriage",
            remedy="Say where they are on their bodies.",
        )
    places = [(m.body, m.x, m.y, m.depth) for m in vision.markers]
    for number, place in enumerate(places):
        if place in places[:number]:
            yield Fault(
                what="two markers at one place",
                key=f"markers {number + 1}",
                got=f"x and y of another one on {place[0]}",
                expected="every place once",
                remedy="Correct x and y.",
            )


def _tag_faults(vision: Vision) -> Iterator[Fault]:
    tags = [s.aruco for s in (*vision.marks, *vision.markers) if s.aruco is not None]
    for tag in sorted({tag for tag in tags if tags.count(tag) > 1}):
        yield Fault(
            what="a tag that is there twice",
            key="aruco",
            got=f"{tags.count(tag)} tags with the number {tag}",
            expected="every number once",
            remedy="Print another one.",
        )
