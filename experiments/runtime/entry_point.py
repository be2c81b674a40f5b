"""What an entry point sets up before it computes, and how it shows what it is doing."""

import contextlib
import os
import pathlib
import sys
from collections.abc import Iterator

from rich.console import Console
from rich.progress import (
    BarColumn,
    TaskProgressColumn,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.progress import Progress as Bar

from scdpr_jax.numerics.files.harmless import printable
from scdpr_jax.numerics.files.private_folder import private_folder
from scdpr_jax.numerics.progress import Progress


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
def shown_progress(console: Console) -> Iterator[Progress]:
    """A progress bar with the time left.

    Args:
        console: Where to show it.

    Yields:
        What computations tell what they are doing.
    """
    with Bar(
        TextColumn("{task.description}", markup=False),
        BarColumn(bar_width=24),
        TaskProgressColumn(),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(compact=True, elapsed_when_finished=False),
        console=console,
        transient=True,
    ) as bar:
        task = bar.add_task("starting", total=1.0)
        yield Progress(
            lambda doing, share: bar.update(task, description=printable(doing), completed=share)
        )
