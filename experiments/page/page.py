"""Filling in the reports' templates: everything from data is escaped."""

import base64
import functools
import hashlib
import importlib.metadata
import platform
import re
from collections.abc import Callable
from typing import Any, NamedTuple

import jinja2
from markupsafe import Markup
from matplotlib.figure import Figure

from experiments.page.number_text import split_at_point
from experiments.page.pictures.drawing import Draw, Drawn, draw
from experiments.page.theme import declarations
from scdpr_jax.numerics.files.harmless import printable

_SCRIPT = re.compile(r"<script>(.*?)</script>", re.DOTALL)
_UNIT = re.compile(r"(?<=\d) (?=(?:%|N|mm|Hz|ms|s|V|mrad|px)(?:\W|$))")
"""The blank between a number and its unit."""
_PACKAGES = ("scdpr-jax", "jax", "jaxlib", "equinox", "numpy", "scipy", "matplotlib")


class Picture(NamedTuple):
    """A figure of a page."""

    name: str
    """Its anchor on the page."""
    svg: Drawn
    """The figure."""
    caption: str
    """What to look at in it."""
    narrow: bool = False
    """Whether it is drawn narrower than the page."""


class Pictures:
    """The figures of one page, each with identifiers of its own."""

    def __init__(
        self, keep: Callable[[Figure], None] = lambda figure: None, *, draw: Draw = draw
    ) -> None:
        """Begin a page.

        Args:
            keep: Told every figure, to keep it somewhere else too.
            draw: What draws the figures.
        """
        self._count = 0
        self._keep, self._draw = keep, draw

    def __call__(
        self, figure: Figure, caption: str, *, seen: str = "", narrow: bool = False
    ) -> Picture:
        """A figure as a picture of the page.

        Args:
            figure: The figure.
            caption: What to look at in it.
            seen: What is to be seen in it, read aloud in its place; default: the caption.
            narrow: Whether another one has room beside it.

        Returns:
            The picture.
        """
        self._count += 1
        self._keep(figure)
        name = f"fig{self._count}"
        return Picture(name, self._draw(figure, name, seen or caption), caption, narrow)


def page(template: str, **content: Any) -> str:
    """A filled-in template.

    Args:
        template: Its file name.
        **content: What it asks for; text is escaped, `Markup` isn't.

    Returns:
        The page.

    Raises:
        jinja2.UndefinedError: If something that it asks for is missing.
    """
    return _environment().get_template(template).render(**content)


@functools.cache
def _environment() -> jinja2.Environment:
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("experiments.page", "templates"),
        autoescape=True,
        finalize=_harmless,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
    )
    environment.globals |= {
        "day": declarations(night=False),
        "night": declarations(night=True),
    }
    environment.filters["code"] = code
    environment.filters["unbroken"] = unbroken
    environment.filters["whole"] = lambda text: split_at_point(text)[0]
    environment.filters["part"] = lambda text: split_at_point(text)[1]
    environment.globals["policy"] = _policy(environment)
    return environment


def _harmless(value: Any) -> Any:
    """A text without what isn't to be seen: marks that turn writing round, a bell."""
    plain = isinstance(value, str) and not isinstance(value, Markup)
    return "\n".join(map(printable, value.split("\n"))) if plain else value


def _policy(environment: jinja2.Environment) -> str:
    """What a browser may load and run of a page: its own styles, and the templates' scripts.

    Should a text from a log ever get through as markup, it can ask for nothing and run nothing.
    """
    sources = (
        environment.loader.get_source(environment, name)[0]
        for name in environment.list_templates()
    )
    scripts = [own for source in sources for own in _SCRIPT.findall(source)]
    digests = [hashlib.sha256(own.encode()).digest() for own in scripts]
    hashes = [f"'sha256-{base64.b64encode(digest).decode()}'" for digest in digests]
    return "; ".join(
        (
            "default-src 'none'",
            "img-src data:",
            "style-src 'unsafe-inline'",
            f"script-src {' '.join(hashes) or repr('none')}",
            "base-uri 'none'",
            "form-action 'none'",
        )
    )


def code(text: str) -> Markup:
    """A sentence whose calls in backticks are set as code.

    Args:
        text: The sentence; it is escaped.

    Returns:
        HTML.
    """
    pieces = re.split(r"`([^`]+)`", text)
    return Markup("").join(
        Markup("<code>{}</code>").format(piece) if place % 2 else piece
        for place, piece in enumerate(pieces)
    )


def unbroken(text: str) -> str:
    """A sentence in which no line ends between a number and its unit.

    Args:
        text: The sentence.

    Returns:
        It, with blanks there that don't break.
    """
    return _UNIT.sub("\N{NO-BREAK SPACE}", text)


def versions() -> tuple[tuple[str, str], ...]:
    """What the numbers were computed with.

    Returns:
        Names and versions of the packages, of Python and of the machine.
    """
    rows = [("Python", f"{platform.python_version()} on {platform.machine()}")]
    for name in _PACKAGES:
        try:
            rows.append((name, importlib.metadata.version(name)))
        except importlib.metadata.PackageNotFoundError:
            rows.append((name, "not installed as a package"))
    return tuple(rows)
