"""Where a leg begins: as it is told, or as a run's camera saw it last."""

import numpy as np
import pytest

from experiments.verbs.starting_pose import FRAMES, beginning
from identification.campaign import CameraStream, Campaign, DriveStream, Run
from identification.campaign.write import write_campaign
from scdpr_jax.robot.parameters import exact
from scdpr_jax.robot.prototype import consistent

ROBOT = exact(consistent())
HEIGHT = float(ROBOT.frame.height)
PLACE, SLOPE = (0.7, 0.4), 2e-3


def resting(count=60, seed=0):
    """A camera's rows of a robot at rest out of line: x_e, delta_e, q_3, q_4, y_e."""
    (x, y), slope = PLACE, SLOPE
    pose = np.array([x, np.arctan(slope), x + slope * y, x - slope * (HEIGHT - y), y])
    return pose + np.random.default_rng(seed).normal(0.0, 1e-5, (count, 5))


def logged(folder, position):
    """A run in which nothing happens; without a camera if it sees nothing."""
    time = np.arange(0.0, 2.0, 1e-3)
    nothing = np.zeros((time.size, 2))
    camera = None
    if position is not None:
        camera = CameraStream(time=np.arange(len(position)) / 30, position=position)
    run = Run(
        name="0001-rest",
        kind="manoeuvre",
        pretension=350.0,
        pretension_label="350 N",
        drive=DriveStream(time=time, voltage=nothing, angle=nothing),
        camera=camera,
    )
    write_campaign(Campaign(name="log", runs=(run,), counts_per_rev=26624.0), folder)
    return folder / run.name


def test_a_run_begins_where_its_last_frames_are(tmp_path):
    position = resting()
    position[: -2 * FRAMES] += 0.1
    begin = beginning(ROBOT, None, None, logged(tmp_path / "log", position))
    np.testing.assert_allclose(begin.place, PLACE, atol=2e-5)
    # Three places, a metre apart, each to 1e-5 m.
    assert begin.slope == pytest.approx(SLOPE, abs=2e-5)


@pytest.mark.parametrize(
    ("seen", "message"),
    [
        (lambda pose: None, "`--start-run`: .*0001-rest has no camera.csv"),
        (lambda pose: np.full_like(pose, np.nan), "has no row in which every marker is seen"),
        (lambda pose: pose + np.eye(5)[2] / 20, "which friction holds at rest"),
    ],
)
def test_a_run_that_tells_no_start_is_refused(tmp_path, seen, message):
    with pytest.raises(ValueError, match=message):
        beginning(ROBOT, None, None, logged(tmp_path / "log", seen(resting())))


def test_what_is_no_run_is_refused(tmp_path):
    logged(tmp_path / "log", resting())
    with pytest.raises(ValueError, match="nowhere, expected a run's folder"):
        beginning(ROBOT, None, None, tmp_path / "log" / "nowhere")


def test_a_leg_begins_in_one_place(tmp_path):
    with pytest.raises(ValueError, match="got 2 of `--from`, `--start` and `--start-run`"):
        beginning(ROBOT, "0.3 m, 0.5 m", "0.3 m, 0.5 m, 0 rad, 0.3 m, 0.3 m", None)
