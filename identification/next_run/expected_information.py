r"""What a run that hasn't been made would tell, expected over what isn't known yet.

Exact friction gives a run grazing events: a carriage only just stops, or only just breaks
away. Derivatives there are huge, yet hold over a vanishing neighbourhood of the parameters; a
search for information finds just these. So information is made of secants over the standard
errors themselves, and standard errors are averaged over robots drawn from what is known:
one robot for which a run happens to be sharp hardly counts.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, PRNGKeyArray

from identification.campaign.types import Sensors
from identification.data.circumstances import MOVING, NAMES, START, Circumstances, Prior
from identification.data.record import Record
from identification.data.start import USUAL_ARM
from identification.fit.residuals import encoder_residuals, frames, move
from identification.fit.unknowns.unknowns import apply, lower_bound
from identification.next_run.excitation import KNOCK_TIME, REST, STEP
from scdpr_jax.engines.stepping import Inputs
from scdpr_jax.robot.fields import real, si
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.state import State, pose

FRAME_RATE = 30.0
"""Rate of the camera [Hz]."""

MARGIN = 0.1
"""How far the end-effector stays clear of the frame beyond its own size [m]."""

KNOCK_SPREAD = 0.3
"""Standard deviation of a knock's force over what was asked for [1]."""


class Rig(eqx.Module):
    """What is known of the rig that the experiment is for."""

    robot: Robot
    """The robot as far as it is known, with exact friction."""
    names: tuple[str, ...] = eqx.field(static=True)
    """The quantities that aren't known exactly."""
    point: Float[Array, " n"] = eqx.field(converter=real, metadata=si("1"))
    """Their values as a fit holds them."""
    root: Float[Array, "n n"] = eqx.field(converter=real, metadata=si("1"))
    """Root of their covariance: itself times its transpose."""
    encoder_sigma: Float[Array, ""] = eqx.field(converter=real, metadata=si("rad"))
    """Error of an encoder's reading [rad]."""
    camera_sigma: Float[Array, "5"] = eqx.field(converter=real, metadata=si("m, rad"))
    """Errors of a frame's positions [m, rad, m, m, m]."""
    count: Float[Array, ""] = eqx.field(converter=real, metadata=si("rad"))
    """Count of the encoders [rad]."""
    log_rate: Float[Array, ""] = eqx.field(converter=real, metadata=si("Hz"))
    """Rate of the logs [Hz]."""
    top_speed: Float[Array, ""] = eqx.field(converter=real, metadata=si("m/s"))
    """Largest speed of the end-effector in either direction [m/s]."""

    def draws(self, key: PRNGKeyArray, count: int) -> Float[Array, "count n"]:
        """Robots that may be the true one.

        Args:
            key: Of the draw.
            count: How many.

        Returns:
            Their quantities as a fit holds them.
        """
        normal = jax.random.normal(key, (count, self.point.size), self.point.dtype)
        return self.bounded(self.point[None] + normal @ self.root.T)

    def covariance(self, units: Float[Array, "m m"]) -> Float[Array, "n n"]:
        """Covariance of the quantities from one in units of what is known now.

        Args:
            units: As in `Expected`.

        Returns:
            Covariance as a fit holds them.
        """
        count = self.point.size
        return self.root @ units[:count, :count] @ self.root.T

    def bounded(self, points: Float[Array, "*lanes n"]) -> Float[Array, "*lanes n"]:
        """Quantities with those that can't be negative at zero at the least.

        Args:
            points: Quantities as a fit holds them.

        Returns:
            The same within their bounds.
        """
        lower = jnp.array([lower_bound(name) for name in self.names])
        return jnp.maximum(points, jnp.broadcast_to(lower, points.shape))


class PlannedRun(eqx.Module):
    """A run as arrays, padded to the longest of its kind."""

    voltage: Float[Array, "... intervals 2"] = eqx.field(converter=real, metadata=si("V"))
    """Commands, each held for `STEP` [V]."""
    start: Float[Array, "... 2"] = eqx.field(converter=real, metadata=si("m"))
    """Start of the end-effector [m]."""
    knock: Float[Array, "..."] = eqx.field(converter=real, metadata=si("N"))
    """Force of the knock; 0 for none [N]."""
    length: Float[Array, "..."] = eqx.field(converter=real, metadata=si("1"))
    """Intervals of the run; the others have no length."""


class Expected(eqx.Module):
    """What a run would tell if the robot were a given one, and whether it is allowed."""

    units: Float[Array | np.ndarray, "... m m"]
    """Covariance with the run, in units of what is known now: of the quantities, then of the
    start's three coordinates and of the knock's force and arm."""
    beyond: Float[Array | np.ndarray, "..."]
    """How far it goes beyond the frame's margin and the speed [m, m/s]; 0 for allowed."""


def expected(rig: Rig, run: PlannedRun, truth: Float[Array, " n"]) -> Expected:
    r"""What a run would tell if the robot were a given one.

    With $u$ the unknowns in units of what is known now, and $r$ what is measured over its
    error,

    $$ P = (I + A^{-T} Y^T Y A^{-1})^{-1}, \qquad
       Y_j = \tfrac12 \big(r(u + A_j) - r(u - A_j)\big), \qquad A A^T = P $$

    so that the secants go over the standard errors that they lead to; two rounds from
    $A = I$.

    Reference: Á. F. García-Fernández, L. Svensson, M. R. Morelande, S. Särkkä, "Posterior
    linearization filter", IEEE Trans. Signal Process. 63(20), 2015,
    doi:10.1109/TSP.2015.2454485.

    Args:
        rig: What is known of the rig.
        run: The run.
        truth: The robot's quantities as a fit holds them.

    Returns:
        Covariance and excursion.
    """
    begun = jnp.eye(rig.point.size + len(NAMES[MOVING]), dtype=truth.dtype)

    def again(units: Float[Array, "m m"], _: None) -> tuple[Array, Array]:
        expectation = expected_over(rig, run, truth, jnp.linalg.cholesky(units))
        return expectation.units, expectation.beyond

    # A loop of two, so that one simulation is compiled.
    units, beyond = jax.lax.scan(again, begun, length=2)
    return Expected(units, beyond[-1])


def expected_over(
    rig: Rig, run: PlannedRun, truth: Float[Array, " n"], over: Float[Array, "m m"]
) -> Expected:
    """What a run would tell, by secants over given distances.

    Args:
        rig: What is known of the rig.
        run: The run.
        truth: The robot's quantities as a fit holds them.
        over: The distances $A$, one a column.

    Returns:
        Covariance and excursion.
    """
    record, count = _record(rig, run), truth.size
    planned = _circumstances(run).vector
    knock_sigma = jnp.stack([KNOCK_SPREAD * run.knock, jnp.asarray(USUAL_ARM)])
    sigma = jnp.concatenate([1 / record.prior.weight[START], knock_sigma])

    def moved(unit: Float[Array, " m"]) -> tuple[State, Array, Array]:
        quantities = rig.bounded(truth + rig.root @ unit[:count])
        circumstances = Circumstances.of(planned.at[MOVING].add(sigma * unit[count:]))
        motion = move(apply(rig.robot, rig.names, quantities), circumstances, record)
        return motion.states, motion.angle, frames(motion, circumstances, record)

    centre = jnp.zeros_like(over[:1])
    states, angle, frame = jax.vmap(moved)(jnp.concatenate([centre, over.T, -over.T]))
    weight = jax.lax.stop_gradient(_encoder_weight(rig, angle[0], record))

    def secants(of: Float[Array, "points rows n"]) -> Float[Array, "m rows n"]:
        return (of[1 : len(over) + 1] - of[len(over) + 1 :]) / 2

    turned = jax.vmap(lambda difference: encoder_residuals(difference, weight))(secants(angle))
    seen = record.frame_weight[None] * secants(frame)
    rows = jnp.concatenate([part.reshape(len(over), -1) for part in (turned, seen)], axis=1)
    whole = over @ jnp.linalg.inv(over.T @ over + rows @ rows.T) @ over.T
    at_truth = jax.tree.map(lambda leaf: leaf[0], states)
    return Expected((whole + whole.T) / 2, _beyond(rig, at_truth, record))


def _record(rig: Rig, run: PlannedRun) -> Record:
    """What is measured of a run; where nothing turns the angles' weights are full."""
    count = run.voltage.shape[0]
    number = jnp.arange(count, dtype=float)
    stamps = (jnp.arange(round(count * STEP * FRAME_RATE), dtype=float) + 0.5) / FRAME_RATE
    seen = (stamps > REST) & (stamps < run.length * STEP)
    knocked = (number > REST / STEP - 0.5) & (number < (REST + KNOCK_TIME) / STEP - 0.5)
    rows = jnp.zeros((count + 1, 2))
    active = (jnp.arange(count + 1, dtype=float) <= run.length)[:, None]
    return Record(
        inputs=Inputs(
            jnp.where(number < run.length, STEP, 0.0),
            run.voltage,
            jnp.where(knocked, 1.0, 0.0),
        ),
        angle=rows,
        angle_weight=jnp.where(active, 1.0, rows),
        angle_share=rows,
        frame_time=stamps,
        frame=jnp.zeros((stamps.size, 5)),
        frame_weight=jnp.where(seen[:, None], 1 / rig.camera_sigma[None], 0.0),
        prior=Prior(
            jnp.zeros(len(NAMES)),
            jnp.full(len(NAMES), jnp.sqrt(REST * FRAME_RATE)) / rig.camera_sigma[0],
        ),
    )


def _circumstances(run: PlannedRun) -> Circumstances:
    """The circumstances of a run as it is planned, its camera's clock the drives' own."""
    x, y = run.start
    return Circumstances(
        lower=x,
        upper=x,
        height=y,
        knock=run.knock,
        knock_arm=0.0,
        clock_offset=0.0,
        clock_drift=0.0,
    )


def _encoder_weight(
    rig: Rig, angle: Float[Array, "rows 2"], record: Record
) -> Float[Array, "rows 2"]:
    """Inverse standard deviations of all readings about each instant.

    A drive that turns by less than a count from sample to sample repeats its reading, which
    is one measurement (`identification.data.record.readings`): there are as many as counts
    passed.
    """
    moved = jnp.abs(jnp.diff(angle, axis=0, prepend=angle[:1]))
    measurements = jnp.clip(moved / rig.count, 1e-2, STEP * rig.log_rate)
    return record.angle_weight * jnp.sqrt(measurements) / rig.encoder_sigma


def _beyond(rig: Rig, states: State, record: Record) -> Float[Array, ""]:
    """How far a motion leaves its limits."""
    lowest, highest = rig.robot.heights
    low = jnp.stack([jnp.asarray(MARGIN), lowest + MARGIN])
    high = jnp.stack([rig.robot.frame.width - MARGIN, highest - MARGIN])
    active = record.angle_weight[:, :1] > 0
    place = jnp.where(active, states.pose, states.pose[:1])
    speed = jnp.where(active, jnp.abs(pose(states.velocity)), 0.0)
    out = jnp.maximum(low[None] - place, 0.0) + jnp.maximum(place - high[None], 0.0)
    return jnp.max(out) + jnp.max(jnp.maximum(speed - rig.top_speed, 0.0))


def rig_errors(sensors: Sensors) -> dict[str, Float[Array, "..."]]:
    """The sensors' noise as a rig takes it.

    Args:
        sensors: The sensors.

    Returns:
        `encoder_sigma` and `camera_sigma`.
    """
    place, angle = sensors.camera_position_sigma, sensors.camera_angle_sigma
    return {
        "encoder_sigma": jnp.asarray(sensors.encoder_sigma),
        "camera_sigma": jnp.array([place, angle, place, place, place]),
    }


@eqx.filter_jit
def motion(rig: Rig, run: PlannedRun) -> State:
    """How the robot would move if it were as it is estimated.

    Args:
        rig: What is known of the rig.
        run: The run.

    Returns:
        States at the ends of the run's intervals.
    """
    robot = apply(rig.robot, rig.names, rig.point)
    return move(robot, _circumstances(run), _record(rig, run)).states
