"""A sweep's map shows what there is to be seen."""

import numpy as np
import xarray as xr

from experiments.figures.sweep_map import sweep_map


def swept(values, *dims):
    units = {"y": "m", "x": "m", "drive_inertia": "kg m^2"}
    coords = {name: (name, np.arange(1.0, n + 1), {"units": units[name]}) for name, n in dims}
    names = [name for name, _ in dims]
    labels = {"condition": ["held", "free"]}
    variable = ((*names, "condition"), values, {"units": "Hz"})
    return xr.Dataset({"frequency": variable}, {**coords, **labels})


def shown(figure):
    return [axes for axes in figure.axes if axes.get_visible() and axes.get_title("left")]


def test_a_panel_for_each_label_that_has_a_number():
    values = np.ones((3, 4, 2))
    values[..., 1] = np.nan
    (panel,) = shown(sweep_map(swept(values, ("y", 3), ("x", 4)), axes=2))
    assert "held" in panel.get_title("left")
    assert (panel.get_xlabel(), panel.get_ylabel()) == ("x [m]", "y [m]")


def test_one_axis_is_a_line_and_of_three_the_first_stands_in_its_middle():
    assert len(shown(sweep_map(swept(np.ones((3, 2)), ("y", 3)), axes=1))) == 2
    values = np.ones((3, 3, 4, 2))
    dims = (("drive_inertia", 3), ("y", 3), ("x", 4))
    panel, _ = shown(sweep_map(swept(values, *dims), axes=3))
    assert "drive_inertia 2.0" in panel.get_title("left")


def test_a_long_label_is_broken_and_stays_inside_the_picture():
    long = "lower carrying the drives' inertia, upper free"
    dataset = swept(np.ones((3, 4, 2)), ("y", 3), ("x", 4)).assign_coords(
        condition=[long, long]
    )
    both = xr.concat([dataset, dataset], "condition")
    figure = sweep_map(both, axes=2)
    figure.draw_without_rendering()
    for panel in shown(figure):
        assert panel.get_tightbbox().x1 < figure.bbox.x1
