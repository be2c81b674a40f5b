"""The text of a proposal, with what no picture tells left empty."""

from collections.abc import Sequence

from identification.vision.proposal.followed import Found
from identification.vision.proposal.patches import Disc, has_hue
from identification.vision.proposal.tagged import together

LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
"""Names of markers in the picture."""
_WIDER = 12.0


_HEAD = """# What a video seems to show. Fill in what is empty, see the picture for the numbers,
# delete discs that are none of the rig's.
format = 1
video = "{video}"{dictionary}

[time]
frame_rate = "{rate:g} Hz"          # by the file; or, with drops, stamps = "frames.csv"
first_frame = "0 s"            # on the camera's clock
exposure = ""                  # of the camera's settings, like "4 ms"
readout = ""                   # first to last row, like "22 ms"; "0 ms": all at once
readout_direction = "down"     # "up" if the picture is upside down
stamp_at = "middle row, mid exposure"

[calibration]
photos = ""                    # of a chessboard by this lens, like "board/*.jpg"
inner_corners = [9, 6]
square = ""                    # side of a square, like "40 mm"
"""
_COLOUR = """
[colours.{name}]
hue = ["{low:.0f} deg", "{high:.0f} deg"]
saturation = ["{saturation:.0f} %", "100 %"]
value = ["{value:.0f} %", "100 %"]
"""
_MARK = """
[[marks]]                      # {number} in the picture: it stays where it is
name = "mark_{number}"
x = ""                         # in the frame's coordinates, like "-45 mm"
y = ""
{look}
"""
_MARKER = """
[[markers]]                    # {letter} in the picture: it moves
body = "{body}"{why}
x = ""                         # from the body's origin, like "-110 mm"
y = ""
depth = ""                     # before the marks' plane, like "20 mm"
{look}
"""
_DISC = """colour = "{colour}"
diameter = ""                  # it is {across:.0f} px across"""
_NEAR = "\nnear = [{u:.1f}, {v:.1f}]"
_TOGETHER = "          # as there are several of its colour, or as they keep their distance"
_ALONE = "                      # lower_carriage, upper_carriage or end_effector"


def document(
    video: str,
    rate: float,
    colours: dict[str, tuple[float, float]],
    discs: Sequence[Disc],
    marks: Sequence[Found],
    markers: Sequence[Found],
    dictionary: str = "",
) -> str:
    """The text of a proposal.

    Args:
        video: The video, as it is to be named.
        rate: Its rate by the file [Hz].
        colours: Lowest and highest hue of each colour [deg].
        discs: Discs of all colours.
        marks: Those that stay where they are.
        markers: Those that move.
        dictionary: Of the tags, empty where there are none.

    Returns:
        A `VISION.toml` to be filled in.
    """
    parts = [_HEAD.format(video=video, rate=rate, dictionary=_printed(dictionary))]
    parts += [_colour(name, hues, discs) for name, hues in colours.items()]
    for number, mark in enumerate(marks, start=1):
        u, v = mark.centre
        near = "" if mark.aruco is not None else _NEAR.format(u=u, v=v)
        parts.append(_MARK.format(number=number, look=_look(mark) + near))
    names = [marker.colour for marker in markers if marker.colour]
    pairs = zip(markers, together(markers), strict=True)
    for letter, (marker, kept) in zip(LETTERS, pairs, strict=False):
        several = kept or names.count(marker.colour) > 1
        parts.append(
            _MARKER.format(
                letter=letter,
                body="end_effector" if several else "",
                why=_TOGETHER if several else _ALONE,
                look=_look(marker),
            )
        )
    return "".join(parts)


def _printed(dictionary: str) -> str:
    """The line that names the tags' dictionary, where there are any."""
    return f'\ndictionary = "{dictionary}"' if dictionary else ""


def _look(found: Found) -> str:
    """What it looks like."""
    if found.aruco is not None:
        return f"aruco = {found.aruco}"
    return _DISC.format(colour=found.colour, across=2 * found.radius)


def _colour(name: str, hues: tuple[float, float], discs: Sequence[Disc]) -> str:
    """A colour's table, somewhat wider than what was seen of it."""
    own = [disc for disc in discs if has_hue(hues, disc.hue)]
    return _COLOUR.format(
        name=name,
        low=(hues[0] - _WIDER) % 360,
        high=(hues[1] + _WIDER) % 360,
        saturation=max(30.0, 100 * min(disc.saturation for disc in own) - 25),
        value=max(8.0, 50 * min(disc.value for disc in own)),
    )
