"""Many legs in one call are each leg by itself, and a stopped call goes on."""

import pytest

from experiments.runtime.executors.chosen import chosen
from experiments.runtime.executors.here import ThisProcess
from experiments.studies.legs.many_legs import write_legs
from scdpr_jax.command.controller import PD
from scdpr_jax.numerics.progress import Progress
from scdpr_jax.robot.parameters import exact
from scdpr_jax.robot.prototype import consistent
from tuning.plan.legs_file import expectation
from tuning.plan.plan_file import plan_table
from tuning.plan.planning import Wanted, plan_leg

ROBOT, CONTROLLER = exact(consistent()), PD(34.46, 1.96)
LEGS = [Wanted((0.3, 0.55), (0.8, 0.4), 1.2), Wanted((0.8, 0.4), (1.2, 0.5), 0.9, 0.0)]


def planned(out, executor=None, **options):
    executor = executor or ThisProcess()
    return write_legs(ROBOT, CONTROLLER, LEGS, out, executor=executor, unit=1, **options)


def test_legs_that_were_stopped_go_on_to_the_plans_of_each_alone(tmp_path):
    def tell(doing, share):
        if share >= 0.5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        planned(tmp_path, progress=Progress(tell))
    assert [path.name for path in tmp_path.iterdir()] == [".legs.unfinished"]
    told = []
    planned(tmp_path, progress=Progress(lambda doing, share: told.append((doing, share))))
    assert ("beginning", 0.5) in told
    names = ["legs.csv", "plan-0001.csv", "plan-0002.csv"]
    assert sorted(path.name for path in tmp_path.iterdir()) == names
    alone = plan_leg(ROBOT, CONTROLLER, (0.8, 0.4), (1.2, 0.5), leg_time=0.9, slope=0.0)
    assert (tmp_path / "plan-0002.csv").read_text() == plan_table(alone.plan)
    table = (tmp_path / "legs.csv").read_text().splitlines()
    assert table[2] == ",".join(("plan-0002.csv", *expectation(alone)))


@pytest.mark.slow
@pytest.mark.parametrize("cluster", [None, "local:2"])
def test_processes_and_a_cluster_write_the_bytes_of_this_process(
    tmp_path, cluster, monkeypatch
):
    if cluster:
        pytest.importorskip("distributed")
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "1")
    planned(tmp_path / "alone")
    with chosen(cluster, None, 2) as executor:
        planned(tmp_path / "shared", executor)
    alone, shared = (
        {path.name: path.read_bytes() for path in (tmp_path / name).iterdir()}
        for name in ("alone", "shared")
    )
    assert len(alone) == 3
    assert alone == shared
