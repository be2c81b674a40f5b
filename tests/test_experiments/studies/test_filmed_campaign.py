"""A campaign whose cameras are videos: drawn, tracked and fitted. Minutes."""

import dataclasses

import jax.numpy as jnp
import numpy as np
import pytest
import scipy.interpolate
from rig_film import shoot, usual

from experiments.virtual_rig.recovery import RUNS, campaign, draw, simulated
from identification.campaign import CameraStream
from identification.campaign.types import HEIGHT_OFFSET
from identification.result.estimation import estimate
from identification.vision.settings import read_vision
from identification.vision.tracking import track

SEED = 3


def filmed(run, motion, folder, number):
    """A run with its camera tracked from a film of its motion."""
    stamps = run.camera.time
    film = dataclasses.replace(
        usual(20 + number), frames=len(stamps), begin=float(stamps[0]), speed=1.0
    )
    shoot(film, folder, coordinates=motion)
    tracked = track(read_vision(folder / "vision.toml"), folder)
    values = tracked.poses.values
    position = np.stack([values[k] for k in ("x_e", "delta_e", "q_3", "q_4", "y_e")], axis=-1)
    camera = CameraStream(time=tracked.clock.frames, position=position)
    sigma = tracked.sigma.columns | {HEIGHT_OFFSET: tracked.sigma.common["y_e"]}
    return dataclasses.replace(run, camera=camera, camera_sigma=sigma)


def motions(truth, seed):
    """What each run with the cable did, as functions of time: the draws of `campaign`."""
    random = np.random.default_rng([seed, 1])
    time = 5e-3 * np.arange(361)
    for (x, y), volts, force in RUNS:
        slope = random.uniform(-0.8, 0.8) * truth.values["friction_coefficient"]
        lower, height = np.array([x + slope * y, y]) + random.normal(0, 5e-4, 2)
        upper = lower - slope * float(truth.robot.frame.height)
        on = ((time >= 0.1) & (time < 0.6))[:, None]
        pushed = np.where((time[:-1] > 0.299) & (time[:-1] < 0.329), force, 0.0)
        random.uniform(2e-3, 30e-3)
        fine = np.linspace(0, time[-1] - 1e-6, 1800)
        _, frame = simulated(
            truth.robot,
            jnp.array([lower, upper, height]),
            jnp.asarray(on[:-1] * np.array(volts)),
            jnp.asarray(pushed),
            jnp.asarray(fine),
        )
        random.normal(size=(int(time[-1] * 30), 5))
        yield scipy.interpolate.PchipInterpolator(fine, np.asarray(frame), extrapolate=False)


def coordinates(spline):
    """A run's motion as the renderer asks for it; at rest before and after."""

    def at(t):
        held = np.clip(np.asarray(t, float), spline.x[0], spline.x[-1])
        x_e, delta_e, q_3, q_4, y_e = np.moveaxis(spline(held), -1, 0)
        return {"x_e": x_e, "y_e": y_e, "delta_e": delta_e, "q_3": q_3, "q_4": q_4}

    return at


@pytest.mark.slow
def test_pretension_and_friction_are_found_by_cameras_that_are_videos(tmp_path):
    truth = draw(SEED)
    logs = campaign(truth, SEED)
    runs = []
    splines = list(motions(truth, SEED))
    for number, run in enumerate(logs.runs):
        if run.camera is None:
            runs.append(run)
            continue
        motion = coordinates(splines[number])
        runs.append(filmed(run, motion, tmp_path / run.name, number))
    fitted = estimate(dataclasses.replace(logs, runs=tuple(runs)))
    found = {each.name: each for each in fitted.parameters}
    for name in ("friction_coefficient", "effective_pretension"):
        true = truth.values[name]
        print(f"{name}: {found[name].value:.6g} ± {found[name].sigma:.2g}, {true:.6g} true")
        assert found[name].value == pytest.approx(true, rel=0.01)
        assert abs(found[name].value - true) < 3 * found[name].sigma
