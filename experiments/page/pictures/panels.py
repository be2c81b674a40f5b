"""A figure cut into its panels, which stand side by side or one below the other.

A figure of two columns that is scaled to a phone's width has letters of four pixels. Cut
into panels, each is as wide as the phone, and its letters stay as they are.
"""

import re
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

NARROW = 5.3
"""Width up to which a figure stays whole: a phone shows it letter for pixel [inch]."""

_POINTS = 72.0
"""Units of a drawing in an inch."""
_BESIDE, _ABOVE = 0.75, 0.75
"""Room for what is written beside and about a panel's axes [inch]."""
_EDGE = 2.0
"""Room about a panel [units]."""


class Panel(NamedTuple):
    """A part of a figure."""

    identifier: str
    """What its group in the drawing is called."""
    box: tuple[float, float, float, float]
    """Left, top, width and height in the drawing [units]."""
    area: str
    """Its place on the grid of a wide page, as a style sheet says it."""
    wide: bool
    """Whether it goes over all columns, as a legend does."""


class Cut(NamedTuple):
    """How a figure is cut."""

    panels: tuple[Panel, ...]
    """Its panels in the order in which they are read."""
    columns: tuple[float, ...]
    """Widths of the columns in relation to each other."""


def cut(figure: Figure) -> Cut | None:
    """Where to cut a figure; its parts are named for it, and its panels spread out.

    Args:
        figure: The figure.

    Returns:
        Its panels; None for one that stays whole, as it is narrow, or its parts belong
        together.
    """
    axes = [each for each in figure.axes if each.get_visible()]
    if figure.get_figwidth() <= NARROW or not _separable(figure, axes):
        return None
    _spread(figure, axes)
    panels = []
    for number, part in enumerate((*figure.legends, *axes)):
        part.set_gid(f"part-{number}")
    boxes = dict(_cells(figure, axes))
    for number, part in enumerate(figure.legends):
        area = f"{number + 1} / 1 / {number + 2} / -1"
        box = _box(figure, _extent(figure, part))
        panels.append(Panel(f"part-{number}", box, area, wide=True))
    for number, each in enumerate(axes, start=len(figure.legends)):
        if each.axison:
            area = _area(each, below=len(figure.legends))
            panels.append(Panel(f"part-{number}", _box(figure, boxes[each]), area, wide=False))
    return Cut(tuple(panels), _columns(axes))


def parts(drawing: str, panels: Sequence[Panel]) -> Iterator[tuple[Panel, str]]:
    """The groups of a drawing's panels.

    Args:
        drawing: The drawing as Matplotlib writes it, a group a line, set in by its depth.
        panels: The panels.

    Yields:
        Each with its group.
    """
    for panel in panels:
        group = re.compile(
            rf'^( +)<g id="{re.escape(panel.identifier)}">$.*?^\1</g>$',
            re.MULTILINE | re.DOTALL,
        )
        found = group.search(drawing)
        if found is None:
            raise RuntimeError(f"a drawing has no group {panel.identifier!r}")
        yield panel, found[0]


def _separable(figure: Figure, axes: Sequence[Axes]) -> bool:
    """Whether a figure is made of panels on a grid, and of nothing besides."""
    marks = (*figure.lines, *figure.patches, *figure.images, *figure.artists)
    loose = (*marks, *figure.texts, *figure.subfigs)
    grids = {id(each.get_gridspec()) for each in axes if each.get_subplotspec() is not None}
    return len(axes) > 1 and not loose and len(grids) == 1 and all(map(_on_a_grid, axes))


def _spread(figure: Figure, axes: Sequence[Axes]) -> None:
    """Give panels their sizes; where they lie is nothing to a figure that is cut.

    A layout that fits them together would measure every word of theirs twice.
    """
    figure.set_layout_engine("none")
    across, down = figure.get_size_inches()
    grid = axes[0].get_gridspec()
    grid.update(
        left=0.0,
        bottom=0.0,
        right=1.0 - _BESIDE / across,
        top=1.0 - _ABOVE / down,
        wspace=_BESIDE / (across / grid.ncols - _BESIDE),
        hspace=_ABOVE / (down / grid.nrows - _ABOVE),
    )
    for each in axes:
        each.set_position(each.get_subplotspec().get_position(figure))


def _area(axes: Axes, *, below: int) -> str:
    """A panel's place on the grid, under so many lines of legends."""
    rows, columns = axes.get_subplotspec().rowspan, axes.get_subplotspec().colspan
    top, bottom = rows.start + below + 1, rows.stop + below + 1
    return f"{top} / {columns.start + 1} / {bottom} / {columns.stop + 1}"


def _on_a_grid(axes: Axes) -> bool:
    return axes.get_subplotspec() is not None


def _columns(axes: Sequence[Axes]) -> tuple[float, ...]:
    grid = axes[0].get_gridspec()
    return tuple(map(float, grid.get_width_ratios()))


def _cells(figure: Figure, axes: Sequence[Axes]) -> Iterator[tuple[Axes, Bbox]]:
    """Panels' boxes, of one width in a column and of one height in a row."""
    extents = [_extent(figure, each) for each in axes]
    places = [each.get_subplotspec() for each in axes]
    for one, place in zip(axes, places, strict=True):
        across = [e for e, p in zip(extents, places, strict=True) if p.colspan == place.colspan]
        along = [e for e, p in zip(extents, places, strict=True) if p.rowspan == place.rowspan]
        wide, high = Bbox.union(across), Bbox.union(along)
        yield one, Bbox.from_extents(wide.x0, high.y0, wide.x1, high.y1)


def _extent(figure: Figure, part: Artist) -> Bbox:
    """A part's box [inch]."""
    box = part.get_tightbbox(figure.canvas.get_renderer())
    return Bbox(box.get_points() / figure.dpi)


def _box(figure: Figure, box: Bbox) -> tuple[float, float, float, float]:
    top = figure.get_figheight() - box.y1
    return (
        _POINTS * box.x0 - _EDGE,
        _POINTS * top - _EDGE,
        _POINTS * box.width + 2 * _EDGE,
        _POINTS * box.height + 2 * _EDGE,
    )
