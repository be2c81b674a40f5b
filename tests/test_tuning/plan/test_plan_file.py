import csv

import numpy as np
import pytest

from scdpr_jax.provenance import Provenance
from tuning.plan.plan import Plan
from tuning.plan.plan_file import CAUTION_COLUMN, COLUMNS, read_plan, write_plan

PLAN = Plan(
    np.arange(4) * 1e-3,
    np.array([[0.3, 0.55], [0.31, 0.55], [0.33, 0.56], [0.34, 0.56]]),
    np.array([[0.0, 0.0], [0.1, 0.1], [0.5, 0.3], [0.7, 0.4]]),
    np.array([[9.0, 8.5], [3.0, -2.0], [0.1, 0.2], [0.0, 0.0]]),
)


def test_a_plan_that_is_written_and_read_is_the_same(tmp_path):
    write_plan(tmp_path / "plan.csv", PLAN)
    again = read_plan(tmp_path / "plan.csv")
    for name in ("time", "position", "angle", "feedforward"):
        # Nine decimals are written.
        np.testing.assert_allclose(getattr(again, name), getattr(PLAN, name), atol=5e-10)


def test_the_header_is_the_one_that_controllers_read(tmp_path):
    write_plan(tmp_path / "plan.csv", PLAN)
    assert (tmp_path / "plan.csv").read_text().splitlines()[0] == (
        "t [s],x_ref [m],y_ref [m],alpha_ref_1 [rad],alpha_ref_2 [rad],"
        "feedforward_1 [V],feedforward_2 [V]"
    )


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("t [s],x [m]\n0,1\n", "row 1: the header is wrong"),
        (",".join(COLUMNS) + "\n0,0,0,0,0,0,0\n0.001,0,0,0,0,zero,0\n", "row 3: got"),
        (",".join(COLUMNS) + "\n0,0,0,0,0,0,0\n0.001,0,0,0,0,0\n", "row 3: got"),
        (",".join(COLUMNS) + "\n0,0,0,0,0,0,nan\n0,0,0,0,0,0,0\n", "row 2: got"),
        (",".join(COLUMNS) + "\n0,0,0,0,0,0,0\n", "got 1 rows"),
        ("", "row 1: the header is wrong"),
    ],
)
def test_a_broken_plan_is_refused_with_its_place(text, told, tmp_path):
    path = tmp_path / "plan.csv"
    path.write_text(text)
    with pytest.raises(ValueError, match=told):
        read_plan(path)


def test_a_missing_plan_says_which_command_writes_it(tmp_path):
    with pytest.raises(ValueError, match="scdpr plan"):
        read_plan(tmp_path / "plan.csv")


def test_a_plan_for_a_robot_that_does_not_fit_is_marked_and_read_alike(tmp_path):
    write_plan(tmp_path / "plan.csv", PLAN, marked=True)
    header, *rows = (tmp_path / "plan.csv").read_text().splitlines()
    assert header.endswith(f",{CAUTION_COLUMN}")
    assert all(row.endswith(",1") for row in rows)
    again = read_plan(tmp_path / "plan.csv")
    np.testing.assert_allclose(again.feedforward, PLAN.feedforward, atol=5e-10)


@pytest.mark.parametrize("marked", [False, True])
def test_the_header_alone_says_where_a_plan_comes_from(tmp_path, marked):
    path = tmp_path / "plan.csv"
    made = Provenance(campaign='rig "A", left', source="0123abcd", date="2026-11-30")
    write_plan(path, PLAN, marked=marked, provenance=made)
    header, *rows = csv.reader(path.read_text().splitlines())
    assert header[-1] == str(made)
    assert {len(row) for row in rows} == {len(COLUMNS) + marked}
    np.testing.assert_array_equal(read_plan(path).angle, PLAN.angle)
