"""A figure as SVG to stand inside an HTML page: no address, no identifier used twice."""

import html
import io
import re

import matplotlib
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from experiments.page.pictures.panels import Cut, cut, parts
from experiments.page.theme import themed
from scdpr_jax.numerics.files.harmless import printable

_OUTER = re.compile(r"^.*?(?=<svg)", re.DOTALL)
_METADATA = re.compile(r"<metadata>.*?</metadata>", re.DOTALL)
_NAMESPACE = re.compile(r'\s+xmlns(?::\w+)?="[^"]*"')
_COMMENT = re.compile(r"<!--.*?-->\n?", re.DOTALL)
# It would hold for the whole page, which says the same once.
_STYLE = re.compile(r"\s*<defs>\s*<style.*?</style>\s*</defs>", re.DOTALL)
_IDENTIFIER = re.compile(r'\bid="')
_REFERENCE = re.compile(r'(?:xlink:)?href="#')
_SIZE = re.compile(r'\s+(?:width|height)="[^"]*"')
_BOX = re.compile(r'viewBox="0 0 ([\d.]+) ([\d.]+)"')
_CLIPS = re.compile(r"^ <defs>$.*?^ </defs>$", re.MULTILINE | re.DOTALL)
# The page's style sheet names the fonts, once.
_FONT = re.compile(r"font-family: [^;\"]*;? ?")
_DIGITS = re.compile(r"(\d+\.\d{2})\d+")

_WIDEST = 1.45
"""How much a figure may be enlarged on a wide page [1]."""


def inline_svg(figure: Figure, *, name: str, description: str) -> str:
    """A figure as `<svg>`: one element, or one for each panel of a wide figure.

    Args:
        figure: The figure.
        name: What its identifiers begin with; every figure of a page needs its own.
        description: What it shows, read aloud to those who can't see it.

    Returns:
        The element, as wide as the page's column at most and without any address.

    Raises:
        ValueError: If the name isn't made of letters, digits and hyphens.
    """
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9-]*", name):
        raise ValueError(
            f"`name` of a figure must be letters, digits and hyphens, got {name!r}: it "
            "becomes part of the page's identifiers. Name the figure by its number."
        )
    file = io.StringIO()
    # Text as text, and identifiers that don't change from one run to the next.
    with matplotlib.rc_context({"svg.fonttype": "none", "svg.hashsalt": name}):
        # A figure that comes from another process has no canvas, which knows sizes of words.
        FigureCanvasAgg(figure)
        how = cut(figure)
        if how is None:
            _lay_out(figure)
        # Not `savefig`, which draws everything twice.
        FigureCanvasSVG(figure).print_svg(file, metadata={"Date": None})
    text = _OUTER.sub("", file.getvalue(), count=1)
    for unwanted in (_METADATA, _NAMESPACE, _COMMENT, _STYLE, _FONT):
        text = unwanted.sub("", text)
    spoken = f'role="img" aria-label="{html.escape(printable(description), quote=True)}"'
    text = _whole(text, spoken) if how is None else _in_panels(text, how, spoken)
    text = _IDENTIFIER.sub(f'id="{name}-', text)
    text = _REFERENCE.sub(f'href="#{name}-', text)
    text = text.replace("url(#", f"url(#{name}-")
    return themed(_shortened(text))


def _whole(text: str, spoken: str) -> str:
    """A figure in one piece."""
    width = float(_BOX.search(text)[1])
    opening, rest = text.split(">", 1)
    opening = _SIZE.sub("", opening).replace(
        "<svg", f'<svg {spoken} style="max-width: {_WIDEST * width:.0f}px"', 1
    )
    return f"{opening}>{rest}"


def _in_panels(text: str, how: Cut, spoken: str) -> str:
    """A figure's panels, on a grid where the page is wide enough for it."""
    # What clips a panel may stand in another one's element.
    rest = "\n".join(_CLIPS.findall(text))
    widest = max(panel.box[2] for panel in how.panels if not panel.wide)
    pieces = []
    for panel, group in parts(text, how.panels):
        box = " ".join(f"{number:.2f}" for number in panel.box)
        # Below each other all have one scale, so that letters are of one size.
        share = min(100 * panel.box[2] / widest, 100)
        style = (
            f"max-width: {_WIDEST * panel.box[2]:.0f}px; --area: {panel.area}; "
            f"--share: {share:.1f}%"
        )
        kind = ' class="wide"' if panel.wide else ""
        pieces.append(
            f'<svg viewBox="{box}" aria-hidden="true" style="{style}"{kind}>{rest}{group}</svg>'
        )
        rest = ""
    columns = " ".join(f"{share:g}fr" for share in how.columns)
    inside = "\n".join(pieces)
    return f'<div class="panels" {spoken} style="--columns: {columns}">{inside}</div>'


def _lay_out(figure: Figure) -> None:
    """Let a figure place its parts once; every later drawing would do it again."""
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.execute(figure)
        figure.set_layout_engine("none")


def _shortened(text: str) -> str:
    """Coordinates to a hundredth of a point, which is finer than any screen."""
    pieces = re.split(r'(\sd="[^"]*"|\s[xy]="[^"]*")', text)
    return "".join(
        _DIGITS.sub(r"\1", part) if place % 2 else part for place, part in enumerate(pieces)
    )
