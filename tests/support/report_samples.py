"""Small made-up results for the reports' tests: no fit, numbers known beforehand."""

import dataclasses

import jax.numpy as jnp
import numpy as np

from identification.campaign.faults import Fault
from identification.campaign.types import CameraStream, Campaign, DriveStream, Knock, Run
from identification.data.circumstances import Circumstances
from identification.fit.comparison import Channel, Comparison
from identification.fit.starts import Valley
from identification.fit.unknowns.models import Model
from identification.judge.identifiability import Identifiability
from identification.judge.influence import Influence
from identification.judge.uncertainty import ParameterEstimate
from identification.knocks.frequency_map import FrequencyMap
from identification.knocks.ring_down import ring_down
from identification.result.estimate import Estimate, Fit
from identification.result.fitted_robot import FittedRobot
from identification.sensitivity.combinations import Combination
from scdpr_jax.command.controller import PD
from scdpr_jax.command.shaper import Shaper
from scdpr_jax.legs.leg import Leg
from scdpr_jax.legs.measures import LegMeasures
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import QUANTITIES, value
from scdpr_jax.robot.state import State
from tuning.loop.margins import sampled_margins
from tuning.loop.plant import published_plant
from tuning.result.prediction import Metrics, Prediction
from tuning.result.regional_shaper import Region, RegionalShaper, ResidualVibration
from tuning.result.tuning import Tuning

ENCODER_SIGMA, CAMERA_SIGMA, ANGLE_SIGMA = 1e-4, 2e-4, 2e-3
TRUTH = {"friction_coefficient": 0.01301, "effective_pretension": 85.5}
FREQUENCY, DAMPING = 3.2, 0.01  # Hz, 1: of the made-up knock


def parameter(name, value, sigma, *, unit, status="identified", setting=None):
    half = 2 * sigma
    return ParameterEstimate(
        name=name,
        setting=setting,
        value=value,
        unit=unit,
        sigma=sigma,
        interval95=(value - half, value + half),
        status=status,
    )


def estimated_parameters():
    return (
        parameter("friction_coefficient", 0.013, 1e-5, unit="1"),
        parameter("drive_inertia", 0.0131, 2e-3, unit="kg m^2", status="weak"),
        parameter("effective_pretension", 85.0, 0.05, unit="N", setting="350 N"),
    )


def comparison(name, *, kind="manoeuvre", held_out=False, camera=True, off=0.0, seed=0):
    """A run whose residuals are noise, and an offset [m] in x_e."""
    random = np.random.default_rng(seed)
    time = np.arange(400) * 5e-3
    frames = np.arange(60) / 30 if camera else np.zeros(0)
    angle = np.stack([3 * np.sin(time), 2 * np.sin(time)], axis=1)
    measured_angle = angle + random.normal(0, ENCODER_SIGMA, angle.shape)

    def path(t):
        return np.stack(
            [
                0.9 + 0.4 * np.sin(t),
                0.02 * np.sin(9 * t),
                0.9 + 0.4 * np.sin(t),
                0.88 + 0.4 * np.sin(t),
                0.5 + 0.1 * np.sin(t),
            ],
            axis=1,
        )

    sigma = np.array([CAMERA_SIGMA, ANGLE_SIGMA, CAMERA_SIGMA, CAMERA_SIGMA, CAMERA_SIGMA])
    simulated = path(frames)
    measured = simulated + random.normal(0, 1, simulated.shape) * sigma
    measured[:, 0] += off
    channels = [
        channel(column, "rad", ENCODER_SIGMA, difference, time)
        for column, difference in zip(
            ("alpha_1", "alpha_2"), (measured_angle - angle).T, strict=True
        )
    ]
    if camera:
        names = ("x_e", "delta_e", "q_3", "q_4", "y_e")
        channels += [
            channel(
                names[i],
                "m" if i != 1 else "rad",
                sigma[i],
                measured[:, i] - simulated[:, i],
                frames,
            )
            for i in range(5)
        ]
    made = Comparison(
        name=name,
        kind=kind,
        held_out=held_out,
        time=time,
        voltage=np.stack([np.sign(np.sin(3 * time)), np.zeros_like(time)], axis=1),
        measured_angle=measured_angle,
        simulated_angle=angle,
        frame_time=frames,
        measured=measured,
        simulated=simulated,
        path=path(time),
        channels=tuple(channels),
    )
    if not camera:
        # As `compare_motors` leaves it: the bare drives have no path.
        object.__setattr__(made, "path", np.zeros((0, 5)))
    return made


def channel(name, unit, sigma, difference, time):
    return Channel(
        name=name,
        unit=unit,
        rms=float(np.sqrt(np.mean(difference**2))),
        sigma=float(sigma),
        motion=0.3,
        worst_time=float(time[np.argmax(np.abs(difference))]),
        count=difference.size,
    )


def campaign(*, name="a rig", clock=0.0, skipped=()):
    def run(number, kind, *, knock=None, with_camera=True):
        time = np.arange(400) * 5e-3
        frames = np.arange(120) / 30
        omega = 2 * np.pi * FREQUENCY
        ringing = np.where(
            frames > 0.4,
            0.01 * np.exp(-DAMPING * omega * frames) * np.cos(omega * frames),
            0.0,
        )
        noise = np.random.default_rng(number).normal(0, CAMERA_SIGMA, (120, 5))
        position = np.tile([0.55, 0.0, 0.55, 0.55, 0.55], (120, 1)) + noise
        position[:, 0] += ringing
        return Run(
            name=f"{number:04d}-{kind.replace('_', '-')}",
            kind=kind,
            pretension=350.0,
            pretension_label="350 N",
            drive=DriveStream(time=time, voltage=np.zeros((400, 2)), angle=np.zeros((400, 2))),
            camera=CameraStream(time=frames, position=position) if with_camera else None,
            notes="tried <b>twice</b>" if number == 1 else "",
            knock=knock,
            clock_offset=clock,
        )

    return Campaign(
        name=name,
        runs=(
            run(1, "manoeuvre"),
            run(2, "manoeuvre"),
            run(3, "pseudo_impulse", knock=Knock(start=0.3, duration=0.03)),
            run(4, "motor_step", with_camera=False),
        ),
        skipped=skipped,
    )


def skipped_run():
    fault = Fault(what="voltage is missing", file="0009-x/drive.csv", remedy="Log it.")
    return (("0009-x", (fault,)),)


def identifiability(parameters):
    names = tuple((p.name, p.setting) for p in parameters)
    count = len(names)
    return Identifiability(
        names=names,
        runs=("0001-manoeuvre", "0004-motor-step"),
        moved=np.arange(4.0 * count).reshape(2, 2, count),
        alone=np.full(count, 1e-3),
        together=np.full(count, 0.2),
        combinations=(
            Combination(names, tuple(np.eye(count)[0]), 1e-3),
            Combination(names, tuple(np.full(count, count**-0.5)), 0.35),
        ),
    )


def influence(parameters, *, moved=0.5, enough=False):
    """One of two runs moves the first quantity by so much; noise by a standard error."""
    count = len(parameters)
    table = np.zeros((2, count))
    table[0, 0] = moved
    values = np.array([p.value for p in parameters])
    sigma = np.array([p.sigma for p in parameters])
    return Influence(
        names=tuple((p.name, p.setting) for p in parameters),
        runs=("0001-manoeuvre", "0004-motor-step"),
        without=values + table * sigma,
        moved=table,
        by_noise=np.ones((2, count)),
        telling=np.full(count, 6.0 if enough else 2.0),
        interval95=tuple(
            (p.value - 3 * p.sigma, p.value + 3 * p.sigma) if enough else None
            for p in parameters
        ),
        resamples=4000,
        seed=0,
    )


def compared_models():
    """The usual model and one that knows more, which is the better one."""
    usual = ("friction_coefficient", "effective_pretension")
    return (
        Model((), usual, 2.5, 3500.0, 3520.0, 1200.0, 7.7e-3),
        Model(
            ("a tension that rises as the loop's path gets longer",),
            (*usual, "loop_stiffness"),
            2.4,
            3300.0,
            3330.0,
            1100.0,
            2.3e-3,
        ),
    )


def estimate(*, off=0.0, held_out=True, parameters=None, models=()):
    parameters = estimated_parameters() if parameters is None else parameters
    fixed = parameter("frame_width", 2.224, 0.0, unit="m", status="fixed")
    return Estimate(
        fitted=FittedRobot(
            robot=consistent(),
            parameters=(*parameters, fixed),
            correlation=np.array([[1.0, 0.1, -0.97], [0.1, 1.0, 0.2], [-0.97, 0.2, 1.0]]),
        ),
        circumstances={"0001-manoeuvre": Circumstances(0.9, 0.9, 0.5, 0.0, 0.0, 0.0123, 0.0)},
        comparisons=(
            comparison("0001-manoeuvre", off=off),
            comparison("0002-manoeuvre", held_out=held_out, seed=1),
            comparison("0003-pseudo-impulse", kind="pseudo_impulse", seed=2),
            comparison("0004-motor-step", kind="motor_step", camera=False, seed=3),
        ),
        fit=Fit(
            starts=(1.0, 1.1),
            valleys=(Valley("350 N", 85.2, 0.0132, 1.1), Valley("350 N", 197.0, 0.006, 3.4)),
            iterations=7,
            ended="converged",
            misfit=0.0,
            measurements=4321.0,
        ),
        identifiability=identifiability(parameters),
        influence=influence(parameters),
        models=models,
        choice=max(len(models) - 1, 0),
    )


def complete(made):
    """An estimate with a row for every quantity, as a fit gives it."""
    rows, robot = made.fitted.parameters, made.fitted.robot
    fixed = tuple(
        parameter(
            kind.name, float(value(robot, kind.name)), 0.0, unit=kind.unit, status="fixed"
        )
        for kind in QUANTITIES
        if kind.name not in {row.name for row in rows}
    )
    fitted = dataclasses.replace(made.fitted, parameters=(*rows, *fixed))
    return dataclasses.replace(made, fitted=fitted)


def frequencies():
    return FrequencyMap(
        x=np.array([0.55]),
        y=np.array([0.55]),
        pretension=np.array([350.0]),
        frequency=np.array([FREQUENCY]),
        frequency_sigma=np.array([0.004]),
        damping_ratio=np.array([DAMPING]),
        damping_ratio_sigma=np.array([0.001]),
        fft_frequency=np.array([3.19]),
        residuals_are_noise=np.array([True]),
        runs=("0003-pseudo-impulse",),
        ring_downs=(knock_ring_down(),),
    )


def knock_ring_down():
    """The ring-down of the campaign's knock."""
    camera = campaign().runs[2].camera
    return ring_down(camera.time, camera.position[:, 0], noise_sigma=CAMERA_SIGMA, after=0.43)


def tracking_run(*, swing):
    """A second of motion and a second of rest, in which x_e swings by so much [m]."""
    time = np.arange(200) * 0.01
    along = np.clip(time, 0, 1)
    reference = np.stack([0.3 + along, np.full(200, 0.5)], axis=1)
    place = reference[:, 0] + swing * np.cos(20 * time)
    still = np.zeros(200)
    position = np.stack([place, still, place, place, reference[:, 1]], axis=1)
    return Leg(
        time=time,
        reference=reference,
        commanded=reference,
        states=State(position, np.zeros((200, 5))),
        voltage=np.zeros((199, 2)),
        measures=LegMeasures(*jnp.zeros(10)),
    )


def metrics(residual):
    return Metrics(
        residual_vibration=residual,
        resting_error=1e-3,
        largest_error=2e-3,
        rms_error=1e-3,
        largest_original_error=0.051,
        largest_voltage=7.5,
        saturation=0.0,
    )


def tuning():
    controller = PD(36.0, 0.7, 1e-3)
    shaper = Shaper([0.0, 0.157], [0.51, 0.49])
    return Tuning(
        controller=controller,
        margins=sampled_margins(published_plant(), controller),
        shapers=(
            RegionalShaper(
                region=Region(x=(0.0, 2.2), y=(0.0, 1.1), pretension=(350.0, 350.0)),
                height=0.55,
                shaper=shaper,
                frequency=FREQUENCY,
                band=(3.1, 3.3),
                damping_ratio=DAMPING,
                measured=True,
                residual_vibration=ResidualVibration(nominal=0.012, worst=0.057),
            ),
        ),
        predicted=(
            Prediction(
                name="horizontal",
                before=metrics(0.0213),
                after=metrics(0.00137),
                run_before=tracking_run(swing=0.02),
                run_after=tracking_run(swing=0.001),
            ),
        ),
        notes=("A note of the <tuning>.",),
    )
