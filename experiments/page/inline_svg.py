"""A figure as SVG to stand inside an HTML page: no address, no identifier used twice."""

import html
import io
import re

import matplotlib
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from scdpr_jax.numerics.files.harmless import printable

_OUTER = re.compile(r"^.*?(?=<svg)", re.DOTALL)
_METADATA = re.compile(r"<metadata>.*?</metadata>", re.DOTALL)
_NAMESPACE = re.compile(r'\s+xmlns(?::\w+)?="[^"]*"')
_COMMENT = re.compile(r"<!--.*?-->\n?", re.DOTALL)
_IDENTIFIER = re.compile(r'\bid="')
_REFERENCE = re.compile(r'(?:xlink:)?href="#')
_SIZE = re.compile(r'(<svg[^>]*?)\s+width="[^"]*"|(<svg[^>]*?)\s+height="[^"]*"')
_DIGITS = re.compile(r"(\d+\.\d{2})\d+")


def inline_svg(figure: Figure, *, name: str, description: str) -> str:
    """A figure as an `<svg>` element.

    Args:
        figure: The figure.
        name: What its identifiers begin with; every figure of a page needs its own.
        description: What it shows, read aloud to those who can't see it.

    Returns:
        The element, as wide as the page's column and without any address.

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
        _lay_out(figure)
        # Not `savefig`, which draws everything twice.
        FigureCanvasSVG(figure).print_svg(file, metadata={"Date": None})
    text = _OUTER.sub("", file.getvalue(), count=1)
    for unwanted in (_METADATA, _NAMESPACE, _COMMENT):
        text = unwanted.sub("", text)
    text = _SIZE.sub(lambda match: match[1] or match[2], text)
    text = _SIZE.sub(lambda match: match[1] or match[2], text)
    text = _IDENTIFIER.sub(f'id="{name}-', text)
    text = _REFERENCE.sub(f'href="#{name}-', text)
    text = text.replace("url(#", f"url(#{name}-")
    text = _shortened(text)
    spoken = html.escape(printable(description), quote=True)
    return text.replace("<svg", f'<svg role="img" aria-label="{spoken}"', 1)


def _lay_out(figure: Figure) -> None:
    """Let a figure place its parts once; every later drawing would do it again."""
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.execute(figure)
        figure.set_layout_engine("none")


def _shortened(text: str) -> str:
    """Coordinates to a hundredth of a point, which is finer than any screen."""
    parts = re.split(r'(\sd="[^"]*"|\s[xy]="[^"]*")', text)
    return "".join(
        _DIGITS.sub(r"\1", part) if place % 2 else part for place, part in enumerate(parts)
    )
