"""Tests of `experiments.sweep`: grids, measures, and what survives a kill."""

import os
import subprocess
import sys
import time

import equinox as eqx
import hypothesis
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import strategies as st

from experiments.runtime.computation import _begun
from experiments.sweep import unit
from experiments.sweep.axes import parse_axes
from experiments.sweep.frequency import FREQUENCY
from experiments.sweep.grid import Grid, blocks
from experiments.sweep.measures import MEASURES
from experiments.sweep.move import CLOSED_LOOP
from experiments.sweep.run import sweep
from experiments.sweep.static_workspace import WORKSPACE
from experiments.sweep.unit import Sweep
from scdpr_jax.command.controller import published_pd
from scdpr_jax.command.trajectory import rest_to_rest
from scdpr_jax.engines.closed_loop import closed_loop
from scdpr_jax.linear.modes import CONDITIONS, natural_frequencies
from scdpr_jax.numerics.progress import Progress
from scdpr_jax.provenance import Provenance
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace
from scdpr_jax.robot.state import rest


def axes(measure, *texts):
    return parse_axes(texts, measure.known)


def swept(tmp_path, measure, *texts, **options):
    robot = consistent()
    return sweep(measure, axes(measure, *texts), robot, tmp_path / "out.nc", **options)


# Axes and grids


def test_an_axis_has_both_ends_and_its_unit_is_converted():
    (axis,) = axes(FREQUENCY, "y=200..900:3 mm")
    np.testing.assert_allclose(axis.values, [0.2, 0.55, 0.9], rtol=1e-15)


def test_a_list_keeps_its_order():
    (axis,) = axes(FREQUENCY, "effective_pretension = 100, 70,85 N")
    np.testing.assert_array_equal(axis.values, [100, 70, 85])


@pytest.mark.parametrize(
    ("texts", "said"),
    [
        ((), "one axis or more"),
        (("z=1 m",), "no such axis"),
        (("y",), "VALUE UNIT"),
        (("y=",), "VALUE UNIT"),
        (("y=0.2..0.9 m",), "VALUE UNIT"),
        (("y=0.9..0.2:5 m",), "LOW below HIGH"),
        (("y=0.2..0.9:1 m",), "COUNT 2 or more"),
        (("y=0.2..0.9:5",), "without its unit"),
        (("y=0.2..0.9:5 N",), "no unit of the right dimension"),
        (("y=0.2, 0.2 m",), "stands twice"),
        (("effective_pretension=0, 10 N",), "values above 0"),
        (("friction_coefficient=-0.1, 0.1",), "values of or above 0"),
        (("y=0.2, 0.3 m", "y=0.4 m"), "each once"),
    ],
)
def test_what_is_no_grid_is_named_with_what_was_expected(texts, said):
    with pytest.raises(ValueError, match=said):
        axes(FREQUENCY, *texts)


def test_every_default_of_every_measure_is_a_finite_number():
    for measure in MEASURES:
        for variable in measure.known:
            assert np.isfinite(float(variable.default(consistent())))


@hypothesis.given(
    shape=st.lists(st.integers(1, 7), min_size=1, max_size=4), most=st.integers(1, 60)
)
def test_blocks_are_the_grid_in_its_order(shape, most):
    grid = np.arange(np.prod(shape)).reshape(shape)
    found = list(blocks(tuple(shape), most))
    for block in found:
        np.testing.assert_array_equal(
            grid[block.place].ravel(), np.arange(block.first, block.last)
        )
    assert [block.first for block in found] == [0, *(block.last for block in found[:-1])]
    assert found[-1].last == grid.size
    assert all(block.last - block.first <= most for block in found)


# Measures


def test_frequencies_are_those_of_each_point(tmp_path):
    with swept(tmp_path, FREQUENCY, "y=0.2, 0.7 m", "drive_inertia=0.01, 0.02 kg m^2") as found:
        assert found.frequency.dims == ("y", "drive_inertia", "condition", "mode")
        assert found.frequency.attrs["units"] == "Hz"
        for height in (0.2, 0.7):
            for inertia in (0.01, 0.02):
                robot = replace(consistent(), {"drive_inertia": inertia})
                here = found.frequency.sel(y=height, drive_inertia=inertia).values
                for row, condition in zip(here, CONDITIONS, strict=True):
                    alone = natural_frequencies(robot, jnp.asarray(height), condition)
                    # A few roundings: compiled in a batch.
                    np.testing.assert_allclose(row[: alone.size], alone, rtol=1e-12)
                    assert np.isnan(row[alone.size :]).all()


def test_frequencies_at_mid_height_are_those_the_paper_leads_to(tmp_path):
    # The table of PAPER_FACTS: first elastic mode at 200, 350 and 500 N.
    expected = {
        "lower free of the drives, upper free": (5.40, 7.14, 8.54),
        "lower carrying the drives' inertia, upper free": (3.68, 4.86, 5.81),
        "lower held, upper free": (2.97, 3.93, 4.69),
        "lower held, upper held": (4.82, 6.38, 7.62),
    }
    with swept(
        tmp_path, FREQUENCY, "y=0.556 m", "effective_pretension=200, 350, 500 N"
    ) as found:
        for condition, first in expected.items():
            values = found.frequency.sel(condition=condition, mode=1).values[0]
            np.testing.assert_allclose(values, first, atol=0.006)


@pytest.mark.parametrize("height", [0.0, 0.1405, 0.98, 1.2])
def test_a_height_out_of_reach_has_no_frequency(tmp_path, height):
    with swept(tmp_path, FREQUENCY, f"y={height} m") as found:
        assert np.isnan(found.frequency.values).all()


def test_single_loops_workspace_is_65_percent_of_the_frame(tmp_path):
    # Centres of 8 mm cells; the border cuts one row of them at the most on either side.
    grid = "x=0.004..2.22:278 m", "y=0.004..1.108:139 m"
    with swept(tmp_path, WORKSPACE, *grid) as found:
        share = float(found.single_loop.mean())
        assert found.single_loop.dtype == bool
    assert abs(share - 0.651) < 0.008 / 1.112 + 0.008 / 2.224


def test_four_cables_have_the_poses_that_need_no_more_than_the_largest_tension(tmp_path):
    grid = "x=0.1..2.1:21 m", "y=0.1..1.0:10 m", "maximum_tension=60, 150 N"
    with swept(tmp_path, WORKSPACE, *grid) as found:
        within = found.needed_tension <= found.maximum_tension
        assert bool((found.four_cables == within).all())
        assert 0 < float(found.four_cables.mean()) < 1


def test_closed_loop_is_the_simulators(tmp_path):
    grid = "leg_time=0.5, 0.75 s", "y=0.4 m", "x=0.5, 2 m"
    with swept(tmp_path, CLOSED_LOOP, *grid) as found:
        here = found.sel(leg_time=0.5, x=0.5, y=0.4)
        start = jnp.array([0.5, 0.4])
        leg = rest_to_rest(start, start + jnp.array([0.4, 0.0]), duration=0.5)
        reference = jax.vmap(leg.position)(1e-3 * jnp.arange(1501.0))
        robot = consistent()
        run = eqx.filter_jit(closed_loop)(
            robot,
            rest(robot, *start[jnp.array([0, 0, 1])]),
            published_pd(),
            reference=reference,
        )
        q = np.asarray(run.states.position)
        # The batch sums in another order; friction's switching keeps that far below.
        close = {"rtol": 1e-7, "atol": 1e-10}
        np.testing.assert_allclose(here.vibration, np.ptp(q[500:1500, 0]), **close)
        # Where the line between the carriages is after the judged second.
        rested = q[1499, 2] + (q[1499, 3] - q[1499, 2]) * q[1499, 4] / float(robot.frame.height)
        off = np.hypot(rested - reference[-1, 0], q[1499, 4] - reference[-1, 1])
        np.testing.assert_allclose(here.resting_error, off, **close)
        np.testing.assert_allclose(here.largest_tilt, np.abs(q[:, 1]).max(), **close)
        # From 2 m the move would end beyond the frame's end.
        beyond = found.sel(x=2)
        assert not beyond.reachable.any()
        assert np.isnan(beyond.vibration).all()


# What is kept


GRID = ("y=0.2..0.9:100 m", "effective_pretension=50..300:200 N")
SMALL = FREQUENCY._replace(unit=4096)
"""Frequencies in units that are small enough for the grid to have five of them."""


def stopping_at(share):
    def tell(doing, done):
        if done >= share:
            raise KeyboardInterrupt

    return Progress(tell)


def test_a_stopped_sweep_ends_with_the_same_bits(tmp_path):
    whole, out = tmp_path / "whole.nc", tmp_path / "out.nc"
    grid = axes(FREQUENCY, *GRID)
    sweep(SMALL, grid, consistent(), whole).close()
    with pytest.raises(KeyboardInterrupt):
        sweep(SMALL, grid, consistent(), out, progress=stopping_at(0.5))
    assert not out.exists()

    told = []
    progress = Progress(lambda doing, share: told.append((doing, share)))
    sweep(SMALL, grid, consistent(), out, progress=progress).close()
    assert out.read_bytes() == whole.read_bytes()
    assert next(share for doing, share in told if doing == "beginning") > 0.3
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out.nc", "whole.nc"]


def test_a_unit_that_was_damaged_is_named_and_computed_anew(tmp_path):
    whole, out = tmp_path / "whole.nc", tmp_path / "out.nc"
    grid = axes(FREQUENCY, *GRID)
    sweep(SMALL, grid, consistent(), whole).close()
    with pytest.raises(KeyboardInterrupt):
        sweep(SMALL, grid, consistent(), out, progress=stopping_at(0.5))
    first = tmp_path / ".out.nc.unfinished" / "00000000.unit"
    record = bytearray(first.read_bytes())
    record[len(record) // 2] ^= 1 << 3
    first.write_bytes(record)
    told = []
    sweep(SMALL, grid, consistent(), out, distrusted=told.append).close()
    assert told == [(first.name, "damaged")]
    assert out.read_bytes() == whole.read_bytes()


def test_a_point_that_cannot_be_computed_leaves_the_others_and_no_file(tmp_path, monkeypatch):
    def half(number, payload):
        return bytes(1 // 0) if number == 1 else begun(number, payload)

    begun = unit.begin(Sweep(SMALL, Grid(axes(FREQUENCY, *GRID)), consistent()).parcel())
    monkeypatch.setattr(unit, "begin", lambda parcel: half)
    _begun.cache_clear()
    with pytest.raises(FloatingPointError, match=r"1 of 5 parts .* 4,096 to 8,191: ZeroDiv"):
        sweep(SMALL, axes(FREQUENCY, *GRID), consistent(), tmp_path / "out.nc")
    assert not (tmp_path / "out.nc").exists()
    monkeypatch.undo()
    _begun.cache_clear()
    told = []
    progress = Progress(lambda doing, share: told.append((doing, share)))
    sweep(
        SMALL, axes(FREQUENCY, *GRID), consistent(), tmp_path / "out.nc", progress=progress
    ).close()
    assert next(share for doing, share in told if doing == "beginning") > 0.7


def test_a_killed_command_goes_on_to_the_same_bits(tmp_path):
    out, whole = tmp_path / "out.nc", tmp_path / "whole.nc"
    grid = ("y=0.2..0.9:200 m", "effective_pretension=50..300:700 N")
    command = [sys.executable, "-m", "experiments.cli", "sweep", "frequency", "--over", *grid]
    environment = {**os.environ, "XDG_CACHE_HOME": str(tmp_path / "cache")}

    def to(path):
        return [*command, "--out", str(path)]

    folder = tmp_path / ".out.nc.unfinished"
    first = subprocess.Popen(to(out), env=environment, stdout=subprocess.DEVNULL)
    while first.poll() is None and not any(folder.glob("*.unit")):
        time.sleep(0.002)
    first.kill()
    assert first.wait() == -9
    assert 0 < len(list(folder.glob("*.unit"))) < 3
    assert not out.exists()

    for path in (out, whole):
        done = subprocess.run(
            to(path), env=environment, capture_output=True, text=True, check=True
        )
        assert f"wrote {path}" in done.stdout
    assert out.read_bytes() == whole.read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "cache",
        *("out.nc", "out.png"),
        *("whole.nc", "whole.png"),
    ]


def test_another_sweeps_parts_are_not_gone_on_with(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        swept(tmp_path, SMALL, *GRID, progress=stopping_at(0.3))
    with pytest.raises(ValueError, match=r"another call has begun \(axes differ\)"):
        swept(tmp_path, SMALL, GRID[0], "effective_pretension=50..301:200 N")


def test_a_file_that_exists_is_not_written_over(tmp_path):
    (tmp_path / "out.nc").write_text("mine")
    with pytest.raises(ValueError, match="exists already"):
        swept(tmp_path, FREQUENCY, "y=0.5 m")
    assert (tmp_path / "out.nc").read_text() == "mine"


def test_a_dataset_says_what_was_not_swept_and_where_it_comes_from(tmp_path):
    made = Provenance(campaign="rig A", source="0123abcd", date="2026-11-30", version="1")
    with swept(tmp_path, WORKSPACE, "x=0.5, 1 m", provenance=made) as found:
        assert (found.attrs["campaign"], found.attrs["logs"]) == ("rig A", "0123abcd")
        assert "2026" not in str(found.attrs)
        assert found.attrs["minimum_tension"] == "10 N"
        assert found.attrs["effective_pretension"] == "85 N"
        assert "x" not in found.attrs
        assert found.x.attrs["units"] == "m"


_PEAK = """
import pathlib, resource, sys
import jax
from experiments.sweep.axes import parse_axes
from experiments.sweep.frequency import FREQUENCY
from experiments.sweep.run import sweep
from scdpr_jax.robot.prototype import consistent
count, out = int(sys.argv[1]), pathlib.Path(sys.argv[2])
over = ["y=0.2..0.9:1000 m", f"effective_pretension=50..300:{count} N"]
grid = parse_axes(over, FREQUENCY.known)
sweep(FREQUENCY, grid, consistent(), out).close()
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


@pytest.mark.slow
def test_memory_stays_flat_to_a_million_points(tmp_path):
    def peak(count):
        command = [sys.executable, "-c", _PEAK, str(count), str(tmp_path / f"{count}.nc")]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        return int(done.stdout)  # [KiB]

    # A million results are 72 MB in single precision, and not held.
    assert peak(1000) < 1.1 * peak(100)


def test_a_sweep_that_was_stopped_after_all_was_done_is_done(tmp_path, monkeypatch):
    out = tmp_path / "out.nc"
    grid = axes(FREQUENCY, "y=0.5, 0.6 m")

    def stopped(store):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("experiments.runtime.store.store.Store.remove", stopped)
        with pytest.raises(KeyboardInterrupt):
            sweep(FREQUENCY, grid, consistent(), out)
    whole = out.read_bytes()
    sweep(FREQUENCY, grid, consistent(), out).close()
    assert out.read_bytes() == whole
    assert [path.name for path in tmp_path.iterdir()] == ["out.nc"]


def test_somebody_elses_file_is_not_taken_for_a_result(tmp_path):
    out = tmp_path / "out.nc"
    grid = axes(FREQUENCY, *GRID)
    with pytest.raises(KeyboardInterrupt):
        sweep(SMALL, grid, consistent(), out, progress=stopping_at(0.5))
    out.write_text("mine")
    with pytest.raises(ValueError, match="exists already"):
        sweep(SMALL, grid, consistent(), out)
    assert out.read_text() == "mine"


@pytest.mark.parametrize("count", [1, 100_000, 131_072, 1_000_000, 10_000_000])
def test_a_sweep_of_millions_has_longer_units_within_their_limit(count):
    unit = CLOSED_LOOP.of_size(count).unit
    assert CLOSED_LOOP.unit <= unit <= CLOSED_LOOP.most
    assert unit % CLOSED_LOOP.chunk == 0
    assert (unit > CLOSED_LOOP.unit) == (count >= 2 * 256 * CLOSED_LOOP.unit)
