"""What an entry point sets up before it computes, and how it shows what it is doing."""

import contextlib
import math
import os
import pathlib
import re
import sys
import time
from collections.abc import Callable, Iterator

from rich.console import Console
from rich.live import Live
from rich.text import Text

from experiments.page.console_text import print_text
from experiments.page.pace import Clock, expected, keep
from experiments.page.wrapping import wrapped
from scdpr_jax.numerics.files.harmless import printable
from scdpr_jax.numerics.files.private_folder import private_folder
from scdpr_jax.numerics.progress import Progress

_BAR = 24
"""Letters of a bar: with the times beside it, it fits into 60 columns."""
_COUNTED = re.compile(r":? ?\d[\d,]* of \d[\d,]*.*$")
"""The end of what counts up: "3 of 12 legs"."""


def set_up(*, double: bool = True, all_cores: bool = False) -> None:
    """Float64, on the CPU, with compiled functions kept from one run to the next.

    Args:
        double: Whether to compute in float64; fits need it, maps don't.
        all_cores: Whether each core is a device of its own, for `scdpr_jax.numerics.batches`.
    """
    import jax  # Not before there is something to compute: `--help` doesn't wait for it.

    jax.config.update("jax_enable_x64", double)
    if all_cores:
        jax.config.update("jax_num_cpu_devices", os.cpu_count() or 1)
    try:
        cache = private_folder(_cache_folder())
    except (OSError, RuntimeError) as reason:
        print(f"compiled programs aren't kept: {reason}", file=sys.stderr)
        return
    jax.config.update("jax_compilation_cache_dir", str(cache))
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)


def _cache_folder() -> pathlib.Path:
    """Where compiled programs are kept: they are code, see `private_folder`.

    Raises:
        RuntimeError: If the user has no home.
    """
    return pathlib.Path(
        os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache", "scdpr-jax"
    )


@contextlib.contextmanager
def shown_progress(console: Console, name: str, given: object = "") -> Iterator[Progress]:
    """A progress bar with the time left, or where there is no terminal a line a stage.

    Args:
        console: Where to show it.
        name: What runs, by which it is known the next time.
        given: What it is given, the campaign for one: how long that took counts more.

    Yields:
        What computations tell what they are doing.
    """
    kept, of = _paces_file(), os.path.abspath(str(given)) if given else ""
    clock = Clock(expected(name, kept, given=of), time.monotonic())
    shown = _bar if console.is_terminal and not console.is_dumb_terminal else _stages
    with shown(console, clock) as told:
        yield Progress(told)
    keep(name, clock.pace(time.monotonic()), kept, given=of)


@contextlib.contextmanager
def _bar(console: Console, clock: Clock) -> Iterator[Callable[[str, float], None]]:
    """A bar that goes on by the clock, and below it what is being done."""
    doing = ["begins"]

    def tell(what: str, share: float) -> None:
        doing[0] = printable(what)
        clock.tell(share, time.monotonic())

    def drawn() -> Text:
        standing = clock.standing(time.monotonic())
        full = round(_BAR * standing.share)
        done, rest = ("━", "╌") if console.encoding.startswith("utf") else ("#", "-")
        left = "" if math.isnan(standing.left) else f", {_minutes(standing.left)} left"
        passed = _minutes(time.monotonic() - begun)
        line = f"{done * full}{rest * (_BAR - full)} {100 * standing.share:3.0f} %"
        told = wrapped(f"  {doing[0]}", console.width, hanging="  ")
        return Text("\n".join([f"{line}  {passed}{left}", *told]))

    begun = time.monotonic()
    with Live(console=console, transient=True, refresh_per_second=4, get_renderable=drawn):
        yield tell


@contextlib.contextmanager
def _stages(console: Console, clock: Clock) -> Iterator[Callable[[str, float], None]]:
    """A line for each stage: what counts up within one has none of its own."""
    begun, last = time.monotonic(), [""]

    def tell(what: str, share: float) -> None:
        now = time.monotonic()
        clock.tell(share, now)
        stage = printable(_COUNTED.sub("", what))
        if stage and stage != last[0]:
            last[0] = stage
            done = 100 * clock.standing(now).share
            print_text(console, f"{done:3.0f} %  {_minutes(now - begun)}  {stage}")

    yield tell


def _minutes(seconds: float) -> str:
    """A time as people read it: "1:05"."""
    return f"{int(seconds) // 60}:{int(seconds) % 60:02d}"


def _paces_file() -> pathlib.Path | None:
    """Where is kept how long things take; None where nothing is."""
    try:
        return private_folder(_cache_folder()) / "paces.json"
    except (OSError, RuntimeError):
        return None
