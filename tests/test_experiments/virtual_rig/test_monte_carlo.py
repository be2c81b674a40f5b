"""A Monte Carlo of fits is units: stopped, shared out or not, its table has the same bytes."""

import csv

import pytest

from experiments.runtime.executors.chosen import chosen
from experiments.runtime.executors.here import ThisProcess
from experiments.virtual_rig import unit
from experiments.virtual_rig.monte_carlo import monte_carlo
from experiments.virtual_rig.recovery import DRAWN, Outcome, draw
from scdpr_jax.numerics.progress import SILENT, Progress

SEEDS = range(700, 703)


def outcome(seed):
    truth = draw(seed).values
    return Outcome(
        seed,
        "converged",
        truth,
        dict.fromkeys(DRAWN, 0.0001 * seed),
        dict.fromkeys(DRAWN, 0.5),
        {name: name != "drive_inertia" for name in DRAWN},
    )


def made(out, progress=SILENT, executor=None):
    return monte_carlo(SEEDS, out, executor=executor or ThisProcess(), progress=progress)


def test_a_stopped_monte_carlo_goes_on_to_the_same_table(tmp_path, monkeypatch):
    monkeypatch.setattr(unit, "recovered", outcome)
    made(tmp_path / "whole.csv")

    def tell(doing, share):
        if share >= 0.5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        made(tmp_path / "stopped.csv", Progress(tell))
    found = made(tmp_path / "stopped.csv")
    texts = [(tmp_path / f"{name}.csv").read_text() for name in ("whole", "stopped")]
    assert texts[0] == texts[1]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["stopped.csv", "whole.csv"]
    assert found.summary()[:3] == [
        "right minimum: 0 of 3",
        "friction_coefficient: 95 % intervals hold the truth in 0 of 0",
        "drive_inertia: 95 % intervals hold the truth in 0 of 0",
    ]


def test_a_robot_that_cannot_be_estimated_is_a_row_with_its_reason(tmp_path, monkeypatch):
    def fails(seed):
        if seed == SEEDS[1]:
            raise FloatingPointError("not\nfinite")
        return outcome(seed)

    monkeypatch.setattr(unit, "recovered", fails)
    found = made(tmp_path / "out.csv")
    assert list(found.failed) == [701]
    with (tmp_path / "out.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["seed"] for row in rows] == ["700"] * 4 + ["701"] + ["702"] * 4
    assert rows[4]["reason"] == "FloatingPointError: not finite"
    monkeypatch.setattr(unit, "recovered", outcome)
    assert not made(tmp_path / "out.csv").failed
    assert [path.name for path in tmp_path.iterdir()] == ["out.csv"]


@pytest.mark.slow
@pytest.mark.parametrize("cluster", [None, "local:2"])
def test_processes_and_a_cluster_write_the_bytes_of_this_process(
    tmp_path, cluster, monkeypatch
):
    if cluster:
        pytest.importorskip("distributed")
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "1")
    alone = made(tmp_path / "alone.csv")
    assert sum(one.right for one in alone.outcomes) == len(SEEDS)
    with chosen(cluster, None, 2) as executor:
        made(tmp_path / "shared.csv", executor=executor)
    assert (tmp_path / "alone.csv").read_bytes() == (tmp_path / "shared.csv").read_bytes()
