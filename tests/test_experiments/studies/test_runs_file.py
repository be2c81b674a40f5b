import numpy as np
import pytest
from report_samples import comparison

from experiments.studies.runs_file import COLUMNS, RATE, read_runs, runs_table


def test_runs_come_back_as_they_were_written(tmp_path):
    run = comparison("0001-manoeuvre")
    path = tmp_path / "runs.csv"
    path.write_text(runs_table((run, comparison("motors", camera=False))), encoding="utf-8")
    ((name, (time, position)),) = read_runs(path).items()
    assert name == "0001-manoeuvre"
    assert np.diff(time).max() <= 1 / RATE + 1e-9
    there = np.stack([np.interp(time, run.time, column) for column in run.path.T], axis=1)
    # Seven digits of at most a metre; times to a tenth of a millisecond, at 1 m/s at most.
    assert np.allclose(position, there, atol=1.1e-4)


def test_a_row_that_is_none_is_told_with_its_place(tmp_path):
    path = tmp_path / "runs.csv"
    path.write_text(",".join(COLUMNS) + "\na,0,1,2,3,4,nan\n")
    with pytest.raises(ValueError, match="row 2"):
        read_runs(path)
    path.write_text("t,x\n")
    with pytest.raises(ValueError, match="the header is wrong"):
        read_runs(path)
