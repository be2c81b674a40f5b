"""A `VISION.toml` for a video of which nothing is known but the video.

Discs are found without being told their colours: patches of strong colour whose outline is an
ellipse's, their hues clustered. Tags are read by the dictionary of which most are found. What
stays where it is in pictures from the whole of the video is a mark, what moves a marker, and
two discs of a colour, or tags that keep their distance, are on one body. Where they are on the
rig and how large, no picture tells: that is left for the person, with a picture in which they
have their numbers.
"""

import dataclasses
from collections.abc import Iterator, Sequence
from pathlib import Path

from identification.vision.pictures.opencv import opencv
from identification.vision.pictures.stream import pictures
from identification.vision.proposal.followed import Found, followed
from identification.vision.proposal.patches import Picture, clusters, round_patches
from identification.vision.proposal.tagged import tagged
from identification.vision.proposal.text import LETTERS, document
from scdpr_jax.numerics.files import whole_file, write_whole
from scdpr_jax.numerics.progress import SILENT, Progress

_SAMPLES = 12


@dataclasses.dataclass(frozen=True)
class Proposal:
    """What was written."""

    lines: tuple[str, ...]
    """What was found, in words."""
    picture: Path
    """The picture with numbers."""


def propose(video: Path, target: Path, *, progress: Progress = SILENT) -> Proposal:
    """Write what a video seems to show.

    Args:
        video: The video.
        target: The file to write; its picture has the same name and `.png`.
        progress: Told how far it is.

    Returns:
        What was written.

    Raises:
        ValueError: If the file is there already, or the video can't be read or shows no disc.
    """
    if target.exists():
        raise ValueError(
            f"`--propose`: {target} is there already, and may have been filled in. Move it "
            "away, or name another file."
        )
    shown, rate = _sampled(video, progress)
    dictionary, tags = tagged(shown)
    discs = [list(round_patches(picture)) for picture in shown]
    colours = clusters([disc for each in discs for disc in each])
    found = list(followed(discs, colours, max(shown[0].shape)))
    colours = {name: colours[name] for name in colours if name in {f.colour for f in found}}
    found += tags
    if not found:
        raise ValueError(
            f"{video}: neither a coloured disc nor an ArUco tag was found. Is the light "
            "enough? Discs need a strong colour on a dull ground and 8 px, tags a white rim "
            "and 24 px."
        )
    marks = sorted((f for f in found if not f.moves), key=_place)
    markers = sorted((f for f in found if f.moves), key=_place)
    picture = target.with_suffix(".png")
    every = [disc for each in discs for disc in each]
    write_whole(
        target,
        document(_named(video, target), rate, colours, every, marks, markers, dictionary),
    )
    _draw(picture, shown[0], marks, markers)
    return Proposal(tuple(_lines(colours, dictionary, marks, markers)), picture)


def _sampled(video: Path, progress: Progress) -> tuple[list[Picture], float]:
    """Pictures from the whole of a video, and its rate."""
    with pictures(video) as read:
        step = max(1, read.count // _SAMPLES)
        shown = []
        for frame in read.frames:
            if frame.number % step == 0:
                shown.append(frame.picture.copy())
                progress(f"picture {frame.number}", frame.number / max(read.count, 1))
        return shown, read.rate


def _named(video: Path, target: Path) -> str:
    """A video as a file names it: from its folder if that is above."""
    folder = target.resolve().parent
    whole = video.resolve()
    return str(whole.relative_to(folder)) if whole.is_relative_to(folder) else str(whole)


def _place(found: Found) -> tuple[float, float]:
    return float(found.centre[1] // 100), float(found.centre[0])


def _lines(
    colours: dict[str, tuple[float, float]],
    dictionary: str,
    marks: Sequence[Found],
    markers: Sequence[Found],
) -> Iterator[str]:
    if colours:
        yield f"colours: {', '.join(colours)}"
    if dictionary:
        yield f"tags of the dictionary {dictionary}"
    yield f"marks, which stay where they are: {len(marks)}"
    yield f"markers, which move: {len(markers)}"
    if len(marks) < 4:
        yield "note: four marks are needed, not all on a line"
    if not markers:
        yield "note: nothing moves in this video; turn those marks that are markers into them"


def _draw(
    path: Path, picture: Picture, marks: Sequence[Found], markers: Sequence[Found]
) -> None:
    cv2 = opencv()
    drawn = picture.copy()
    numbered = [(str(k), found) for k, found in enumerate(marks, start=1)]
    numbered += list(zip(LETTERS, markers, strict=False))
    for name, found in numbered:
        at = tuple(round(x) for x in found.centre)
        radius = int(found.radius) + 6
        for step, colour in ((2, (0, 0, 0)), (0, (255, 255, 255))):
            cv2.circle(drawn, (at[0] + step, at[1] + step), radius, colour, 2, cv2.LINE_AA)
            place = (at[0] + radius + step, at[1] - radius + step)
            font = cv2.FONT_HERSHEY_SIMPLEX
            cv2.putText(drawn, name, place, font, 1.2, colour, 2, cv2.LINE_AA)
    with whole_file(path) as scratch:
        scratch.write_bytes(cv2.imencode(".png", drawn)[1].tobytes())
