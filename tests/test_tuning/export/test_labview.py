"""The exported tables, read back as LabVIEW would and simulated again."""

import csv
import re

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tunings import NAMES, TUNINGS

from scdpr_jax.command.controller import PD
from scdpr_jax.command.shaper import Shaper, shape_samples
from tuning.export.description import describe
from tuning.export.labview import controller_table, shapers_table


@pytest.fixture(params=TUNINGS, ids=NAMES)
def tuning(request):
    return request.param


def read(text):
    header, *rows = csv.reader(text.splitlines())
    names = [re.fullmatch(r"(\w+) \[[^\]]+\]", cell)[1] for cell in header]
    return names, np.array(rows, dtype=float)


def read_controller(tuning):
    names, (row,) = read(controller_table(describe(tuning)))
    return dict(zip(names, row, strict=True))


def read_shapers(tuning):
    """Edges, times and amplitudes of each region, in their order."""
    _, table = read(shapers_table(describe(tuning)))
    regions = [table[table[:, 0] == number] for number in np.unique(table[:, 0])]
    return [(rows[0, 1:7], rows[:, 7], rows[:, 8]) for rows in regions]


def test_headers_name_every_column_with_its_unit(tuning):
    description = describe(tuning)
    assert controller_table(description).splitlines()[0] == (
        "proportional_gain [V/rad],derivative_gain [V s/rad],period [s],filter_time [s],"
        "voltage_limit [V],effective_radius [m]"
    )
    assert shapers_table(description).splitlines()[0] == (
        "region [1],x_low [m],x_high [m],y_low [m],y_high [m],pretension_low [N],"
        "pretension_high [N],time [s],amplitude [1]"
    )


def test_every_cell_is_a_plain_decimal_number(tuning):
    description = describe(tuning)
    tables = controller_table(description), shapers_table(description)
    cells = [
        cell for table in tables for row in table.splitlines()[1:] for cell in row.split(",")
    ]
    assert all(re.fullmatch(r"-?\d+(\.\d+)?", cell) for cell in cells)


def test_the_controller_reads_back_to_the_same_bits(tuning):
    found, drive = read_controller(tuning), tuning.robot_at().robot.drive
    expected = {
        name: float(getattr(tuning.controller, name))
        for name in ("proportional_gain", "derivative_gain", "period", "filter_time")
    } | {name: float(getattr(drive, name)) for name in ("voltage_limit", "effective_radius")}
    assert found == expected


def test_regions_and_impulses_read_back_to_the_same_bits(tuning):
    for (edges, times, amplitudes), known in zip(
        read_shapers(tuning), tuning.shapers, strict=True
    ):
        region = known.region
        assert edges.tolist() == [*region.x, *region.y, *region.pretension]
        assert times.tolist() == known.shaper.times.tolist()
        assert amplitudes.tolist() == known.shaper.amplitudes.tolist()


@jax.jit
def commanded(controller, shaper, reference):
    """Commands of a controller that begins at rest and meets no motion."""
    shaped = shape_samples(shaper, reference, period=controller.period)
    zero = jnp.zeros(2)
    start = controller.initial_state(shaped[0], zero)
    return jax.lax.scan(lambda state, now: controller.step(state, now, zero), start, shaped)[1]


def test_what_is_read_back_commands_what_the_tuning_does(tuning):
    found = read_controller(tuning)
    names = ("proportional_gain", "derivative_gain", "period", "filter_time")
    again = PD(*(found[name] for name in names))
    steps = np.random.default_rng(3).normal(0, 1e-3, (700, 2))
    reference = jnp.asarray(np.cumsum(steps, axis=0))
    for (_, times, amplitudes), known in zip(read_shapers(tuning), tuning.shapers, strict=True):
        expected = commanded(tuning.controller, known.shaper, reference)
        got = commanded(again, Shaper(times, amplitudes), reference)
        assert np.array_equal(got, expected)
