"""A sweep's map: every variable over its last two axes, or over its only one."""

import itertools
import textwrap
from collections.abc import Iterator

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.page import style

_PANELS = 12
"""Panels that a picture has at most."""
_POINTS = 400
"""Points along an axis that are drawn at most: a panel has no more pixels."""
_LETTERS = 34
"""Letters of a title that reach from a panel's axis to the picture's edge."""


@style.styled
def sweep_map(dataset: xr.Dataset, *, axes: int) -> Figure:
    """Panels of a sweep, one for each variable and label of its own dimensions.

    Args:
        dataset: The dataset, read as far as it is drawn.
        axes: How many of its leading dimensions are the sweep's axes; of more than two the
            others are drawn in their middle.

    Returns:
        The figure.
    """
    panels = list(itertools.islice(_panels(dataset, axes), _PANELS))
    columns = min(3, len(panels))
    figure, grid = style.panels(
        -(-len(panels) // columns), columns, height=3.2 * -(-len(panels) // columns)
    )
    flat = np.ravel(np.asarray(grid, dtype=object))
    for place, (title, values) in zip(flat, panels, strict=False):
        _draw(place, values)
        place.set_title(title, fontsize=8)
    for empty in flat[len(panels) :]:
        empty.set_visible(False)
    return figure


def _panels(dataset: xr.Dataset, axes: int) -> Iterator[tuple[str, xr.DataArray]]:
    """Titles with two-dimensional or one-dimensional values; those without a number go."""
    for variable in dataset.data_vars.values():
        swept, own = variable.dims[:axes], variable.dims[axes:]
        middle = {name: variable.sizes[name] // 2 for name in swept[:-2]}
        drawn = variable.isel(middle)
        for name in swept[-2:]:
            drawn = drawn.isel({name: slice(None, None, -(-drawn.sizes[name] // _POINTS))})
        for place in np.ndindex(*(variable.sizes[name] for name in own)):
            at = dict(zip(own, place, strict=True))
            values = drawn.isel(at).load().astype(float)
            if np.isfinite(values).any():
                yield _title(variable, {**middle, **at}), values


def _title(variable: xr.DataArray, at: dict[str, int]) -> str:
    """The variable's name with its labels, broken where it would leave its panel."""
    labels = (f"{name} {variable[name].values[place]}" for name, place in at.items())
    lines = (textwrap.fill(text, _LETTERS) for text in (str(variable.name), *labels))
    return "\n".join(lines)


def _draw(axes: Axes, values: xr.DataArray) -> None:
    unit = values.attrs.get("units", "1")
    if values.ndim == 1:
        (along,) = values.dims
        axes.plot(values[along].values, values.values)
        axes.set(xlabel=_label(values, along), ylabel=f"[{unit}]")
        return
    down, along = values.dims
    # The axis that is a height is drawn upwards.
    if along == "y":
        values, down, along = values.T, along, down
    filled = axes.pcolormesh(
        values[along].values, values[down].values, values.values, cmap="viridis"
    )
    axes.set(xlabel=_label(values, along), ylabel=_label(values, down))
    axes.grid(False)
    axes.figure.colorbar(filled, ax=axes, label=f"[{unit}]")


def _label(values: xr.DataArray, name: str) -> str:
    return style.label(name, values[name].attrs.get("units", "1"))
