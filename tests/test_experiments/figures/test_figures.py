"""The figures' numbers; what they look like is for people to judge."""

import dataclasses
import math

import matplotlib
import numpy as np
import pytest
from report_samples import (
    CAMERA_SIGMA,
    TRUTH,
    comparison,
    estimate,
    estimated_parameters,
    frequencies,
    parameter,
)

from experiments.figures.identification.frequency_map import frequency_over_height
from experiments.figures.identification.intervals import intervals, relative_intervals
from experiments.figures.identification.residuals import residuals_in_sigma
from experiments.figures.identification.run_comparison import run_comparison
from experiments.figures.robot_view import cable_loop, shown_instants
from scdpr_jax.robot.prototype import consistent

NORMAL = 1.959963984540054
"""Standard errors in half of an interval of 95 %."""


def texts(figure):
    return [text.get_text() for text in figure.findobj(matplotlib.text.Text)]


def test_what_may_be_zero_is_held_against_its_usual_size():
    (bar,) = relative_intervals([parameter("drive_friction", 3e-6, 2e-6, unit="N m")])
    # A tenth of 0.05 N m, and 1.96 standard errors.
    assert bar.half_width == pytest.approx(NORMAL * 2e-6 / 5e-3, rel=1e-12)
    assert bar.known == "may be zero"


def test_residuals_are_in_units_of_the_noise():
    run = comparison("a")
    moved = dataclasses.replace(run, measured=run.simulated + 3 * CAMERA_SIGMA)
    time, values = residuals_in_sigma(moved)["q_3"]
    assert np.array_equal(time, run.frame_time)
    # A difference of metres: a few roundings of 1 m over 0.2 mm.
    assert np.allclose(values, 3.0, atol=1e-10)


def test_lost_frames_have_no_residual():
    run = comparison("a")
    measured = run.measured.copy()
    measured[10:20] = np.nan
    time, values = residuals_in_sigma(dataclasses.replace(run, measured=measured))["x_e"]
    assert len(time) == len(values) == run.frame_time.size - 10


def test_a_relative_interval_is_half_of_the_interval_over_the_value():
    mu, _, tension = relative_intervals(estimated_parameters(), truth=TRUTH)
    assert mu.half_width == pytest.approx(NORMAL * 1e-5 / 0.013, rel=1e-12)
    assert tension.error == pytest.approx(85.0 / 85.5 - 1, rel=1e-12)
    assert tension.name == "effective pretension at 350 N"


def test_an_unidentifiable_parameter_is_drawn_within_the_axes():
    unknown = parameter("drive_damping", 0.2, math.inf, unit="N m s", status="unidentifiable")
    figure = intervals([*estimated_parameters(), unknown])
    for line in figure.axes[0].lines:
        assert np.isfinite(np.asarray(line.get_xdata(), dtype=float)).all()


def test_settings_without_a_model_are_drawn_all_the_same():
    figure = frequency_over_height(frequencies(), {})
    assert "nominal pretension 350 N" in texts(figure)


def test_cables_are_as_long_as_the_model_has_them():
    robot = consistent()
    x, tilt, lower, upper, y = position = np.array([0.8, 0.05, 0.9, 0.7, 0.5])
    a, b = (float(getattr(robot.end_effector, f"{s}_offset")) for s in ("lower", "upper"))
    height = float(robot.frame.height)
    expected = {
        "alpha": np.hypot(lower - x - a * np.sin(tilt), y - a * np.cos(tilt)),
        "beta": np.hypot(x - upper - b * np.sin(tilt), height - y - b * np.cos(tilt)),
        "gamma": np.hypot(lower - upper, height),
    }
    paths = cable_loop(robot, position)
    for name, length in expected.items():
        drawn = [np.linalg.norm(np.diff(line, axis=0)) for line in paths[name]]
        assert len(drawn) == 2
        # The two sides of a tilted body differ; their mean is the model's length to the
        # second order of the tilt and of the pulleys' half gap over the length.
        assert np.mean(drawn) == pytest.approx(length, rel=2 * tilt**2)


def test_four_instants_lie_inside_a_run():
    instants = shown_instants(np.array([1.0, 2.0, 3.0]))
    assert len(instants) == 4
    assert all(1.0 <= instant <= 3.0 for instant in instants)


@pytest.mark.parametrize("camera", [True, False])
def test_every_panel_of_a_run_has_labels_with_units(camera):
    figure = run_comparison(comparison("a", camera=camera))
    shown = [axes for axes in figure.axes if axes.axison]
    assert len(shown) == (8 if camera else 3)
    assert all("[" in axes.get_ylabel() for axes in shown)


def test_drawing_changes_no_setting_of_the_caller():
    before = dict(matplotlib.rcParams)
    run_comparison(estimate().comparisons[3])
    assert dict(matplotlib.rcParams) == before
