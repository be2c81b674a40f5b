"""Figures drawn at once, or by other processes beside whatever else there is to do.

Matplotlib takes a fifth of a second for a figure of a report, nearly all of it in Python, so
that threads would wait for each other.
"""

import concurrent.futures
from collections.abc import Callable

from markupsafe import Markup
from matplotlib.figure import Figure

from experiments.page.pictures.inline_svg import inline_svg

Draw = Callable[[Figure, str, str], "Drawn"]
"""From a figure, its name and its description to the picture."""


class Drawn:
    """A figure as an `<svg>` element, which may not be there yet."""

    def __init__(self, element: "concurrent.futures.Future[str]") -> None:
        """A picture that somebody draws.

        Args:
            element: What it will be.
        """
        self._element = element

    def __html__(self) -> Markup:
        """The element, once it is there; its text was escaped as it was drawn."""
        return Markup(self._element.result())


def draw(figure: Figure, name: str, description: str) -> Drawn:
    """Draws a figure at once.

    Args:
        figure: The figure.
        name: What its identifiers begin with.
        description: What it shows.

    Returns:
        The picture.
    """
    element: concurrent.futures.Future[str] = concurrent.futures.Future()
    element.set_result(inline_svg(figure, name=name, description=description))
    return Drawn(element)


def draws_by(processes: concurrent.futures.Executor) -> Draw:
    """What draws as `draw` does, and doesn't wait.

    Args:
        processes: Who draws.

    Returns:
        It.
    """

    def aside(figure: Figure, name: str, description: str) -> Drawn:
        return Drawn(processes.submit(inline_svg, figure, name=name, description=description))

    return aside
