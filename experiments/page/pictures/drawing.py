"""Figures drawn by processes of their own, beside whatever else there is to do.

Matplotlib takes a fifth of a second for a figure of a report, nearly all of it in Python, so
that threads would wait for each other.
"""

import atexit
import concurrent.futures
import contextlib
import gc
import multiprocessing
import os
from collections.abc import Callable, Iterator

from markupsafe import Markup
from matplotlib.figure import Figure

from experiments.page.pictures.inline_svg import inline_svg
from scdpr_jax.numerics.processes import deaf_to_interrupts, end_with_pool

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


@contextlib.contextmanager
def drawing_aside(processes: int = os.cpu_count() or 1) -> Iterator[Draw]:
    """Processes that draw figures while others are still made.

    A program that isn't guarded by `if __name__ == "__main__"` would be run anew by each, so
    this is for the command line.

    Args:
        processes: How many. They start at once, as they have libraries to load.

    Yields:
        What draws as `draw` does, and doesn't wait.
    """
    context = multiprocessing.get_context("spawn")
    pool = concurrent.futures.ProcessPoolExecutor(
        processes, mp_context=context, initializer=_begin, initargs=gc.get_threshold()
    )

    def aside(figure: Figure, name: str, description: str) -> Drawn:
        return Drawn(pool.submit(inline_svg, figure, name=name, description=description))

    try:
        with deaf_to_interrupts():
            for _ in range(processes):
                pool.submit(int)  # Nothing, but a process begins for it.
        yield aside
    finally:
        pool.shutdown(cancel_futures=True)


def _begin(*threshold: int) -> None:
    """A process that looks for cycles as the one does that began it, and is ended by it."""
    end_with_pool()
    gc.set_threshold(*threshold)
    atexit.register(os._exit, 0)  # Taking libraries apart at the end serves nobody.
