import numpy as np
import pytest
from report_samples import comparison

from experiments.page.coordinates import COORDINATES
from experiments.reports.calibration.heat_tables import (
    correlation_heat,
    misfit_heat,
    quantity_symbols,
)


def test_each_channel_stands_in_its_own_column_in_times_of_the_noise():
    run = comparison("a", off=5e-3)
    (row,) = misfit_heat((run,)).rows
    for channel in run.channels:
        cell = row.cells[list(COORDINATES).index(channel.name)]
        assert float(cell.text) == pytest.approx(channel.chi_square**0.5, rel=0.05)


def test_channels_beyond_noise_alone_are_strong():
    (row,) = misfit_heat((comparison("a", off=5e-3),)).rows
    strong = [cell.text for cell in row.cells if cell.strong]
    # 5 mm over 0.2 mm.
    assert strong == ["25"]


def test_what_was_not_measured_has_no_number():
    (row,) = misfit_heat((comparison("b", camera=False),)).rows
    assert [cell.text for cell in row.cells[:5]] == ["–"] * 5


def test_a_run_that_was_not_fitted_is_told_in_words():
    (row,) = misfit_heat((comparison("b", held_out=True),)).rows
    assert row.name == "b (not fitted)"


def test_correlations_are_in_hundredths_and_those_near_one_are_strong():
    matrix = np.array([[1.0, -0.97, 0.3], [-0.97, 1.0, -0.001], [0.3, -0.001, 1.0]])
    rows = correlation_heat(("a", "b", "c"), matrix).rows
    assert [cell.text for cell in rows[2].cells] == ["+30", "0", "1"]
    assert [cell.text for cell in rows[1].cells] == ["−97", "1", ""]
    assert [cell.strong for cell in rows[1].cells] == [True, False, False]


def test_a_quantity_of_a_setting_is_told_with_it():
    told = quantity_symbols((("effective_pretension", "350 N"), ("friction_coefficient", None)))
    assert told == ("T 350 N", "μ")


def test_two_quantities_of_one_symbol_are_told_in_words():
    told = quantity_symbols((("drive_damping", None), ("upper_offset", None)))
    assert told == ("drive damping", "upper offset")
