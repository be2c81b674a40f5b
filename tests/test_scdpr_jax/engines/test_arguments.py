"""What an engine can't be called with is refused, and nothing turns into NaN in silence."""

import inspect
import pathlib
import runpy

import equinox as eqx
import jax
import jax.numpy as jnp
import jaxtyping
import numpy as np
import pytest

import scdpr_jax
from scdpr_jax.engines.stepping import possible_inputs
from scdpr_jax.engines.tensioned_loop import Tensioner, simulate_tensioned

CASE = pathlib.Path(__file__).parents[3].parent / "shared/data/cases/simulate-voltage-shape"
STEPS = 4


@pytest.fixture(autouse=True)
def as_users_have_it():
    """Without the shape checks that only tests have."""
    jaxtyping.config.update("jaxtyping_disable", True)
    yield
    jaxtyping.config.update("jaxtyping_disable", False)


def call(**changed):
    """Arguments of a run, some of them changed."""
    rows = {
        "duration": np.full(STEPS, 5e-3),
        "voltage": np.full((STEPS, 2), 3.0),
        "knock": np.zeros(STEPS),
        "position": np.array([0.3, 0.0, 0.3, 0.3, 0.55]),
        "velocity": np.zeros(5),
    }
    return rows | changed


def run(robot=None, **changed):
    given = call(**changed)
    start = scdpr_jax.State(given["position"], given["velocity"])
    inputs = scdpr_jax.Inputs(given["duration"], given["voltage"], given["knock"])
    return scdpr_jax.simulate(scdpr_jax.consistent() if robot is None else robot, start, inputs)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"voltage": np.ones((STEPS, 3))}, r"`voltage` \[V\].* \(4, 2\), got \(4, 3\)"),
        ({"voltage": np.ones((STEPS, 1))}, r"`voltage` \[V\].* \(4, 2\), got \(4, 1\)"),
        ({"voltage": np.ones(STEPS)}, r"`voltage` \[V\].* got \(4,\)"),
        ({"voltage": np.ones((STEPS + 1, 2))}, r"`duration` \[s\].* \(5,\), got \(4,\)"),
        ({"duration": np.full((STEPS, 1), 5e-3)}, r"`duration` \[s\] .* got \(4, 1\)"),
        (
            {"duration": np.array([5e-3, -1.0, 5e-3, 5e-3])},
            r"not be negative \[s\] .*, got -1 to 0.005",
        ),
        ({"duration": np.array([5e-3, np.nan, 5e-3, 5e-3])}, r"`duration\[1\]` must be finite"),
        ({"duration": 5e-3}, r"`duration` \[s\] must have the shape \(n,\), got \(\)"),
        ({"knock": np.zeros(STEPS - 1)}, r"`knock` \[N\] must have the shape \(4,\)"),
        ({"knock": 0.0}, r"`knock` \[N\] must have the shape \(4,\), got \(\)"),
        ({"voltage": np.full((STEPS, 2), np.nan)}, r"`voltage\[0, 0\]` must be finite"),
        ({"position": np.zeros(4)}, r"`start.position` \[m, rad\] must .* \(5,\), got \(4,\)"),
        ({"velocity": np.full(5, np.inf)}, r"`start.velocity\[0\]` must be finite"),
    ],
)
def test_a_run_that_cannot_be_is_refused(changed, message):
    with pytest.raises(ValueError, match=message):
        run(**changed)


@pytest.mark.parametrize("rows", [3, 1])
def test_another_number_of_columns_is_refused_where_it_is_traced(rows):
    @jax.jit
    def traced(voltage):
        return run(voltage=voltage).position

    with pytest.raises(ValueError, match=rf"`voltage` .*\(4, 2\), got \(4, {rows}\)"):
        traced(jnp.ones((STEPS, rows)))


def test_a_traced_duration_below_zero_gives_no_number():
    position = jax.jit(lambda duration: run(duration=duration).position)
    assert jnp.all(jnp.isfinite(position(jnp.full(STEPS, 5e-3))))
    back = position(jnp.full(STEPS, 5e-3).at[2].set(-5e-3))
    assert jnp.all(jnp.isnan(back[1:]))


def test_possible_inputs_stay_as_they_are():
    given = call()
    inputs = scdpr_jax.Inputs(given["duration"], given["voltage"], given["knock"])
    assert eqx.tree_equal(possible_inputs(inputs), inputs)


@pytest.mark.parametrize(
    ("name", "number", "message"),
    [
        ("end_effector_mass", -2.1, r"`robot.end_effector.mass` must be above zero"),
        ("effective_radius", 0.0, r"`robot.drive.effective_radius` must be above zero"),
        ("effective_pretension", np.nan, r"`robot.cable.effective_pretension` must be finite"),
    ],
)
def test_a_robot_that_cannot_be_is_refused(name, number, message):
    robot = scdpr_jax.replace(scdpr_jax.consistent(), {name: number})
    with pytest.raises(ValueError, match=message):
        run(robot)


def test_several_robots_at_once_are_refused():
    robot = eqx.tree_at(lambda r: r.end_effector.mass, scdpr_jax.consistent(), jnp.ones(3))
    with pytest.raises(ValueError, match=r"`robot.end_effector.mass` .* got \(3,\).*vmap"):
        run(robot)


@pytest.mark.parametrize(
    ("places", "message"),
    [
        ((0.3, 0.3, -0.1), r"`height` .* within the frame \[m\]"),
        ((0.3, 0.3, 2.0), r"`height` .* within the frame \[m\]"),
        ((0.3, np.nan, 0.5), r"`upper` must be in the frame \[m\]"),
        (
            (np.ones(3), np.ones(3), np.ones(3)),
            r"`lower` must be one number \[m\], got .*\(3,\)",
        ),
    ],
)
def test_a_rest_that_cannot_be_is_refused(places, message):
    with pytest.raises(ValueError, match=message):
        scdpr_jax.rest(scdpr_jax.consistent(), *places)


def linear(**changed):
    robot = scdpr_jax.consistent()
    given = {"height": 0.5, "interval": 5e-3, "voltage": np.ones((STEPS, 2))} | changed
    start = scdpr_jax.rest(robot, 0.3, 0.3, 0.5)
    given = {k: v if k == "substeps" else jnp.asarray(v) for k, v in given.items()}
    return scdpr_jax.simulate_linear(robot, start, **given)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"voltage": np.ones((STEPS, 3))}, r"`voltage` .* \(n, 2\), got \(4, 3\)"),
        ({"knock": np.ones(STEPS + 1)}, r"`knock` .* \(4,\), got \(5,\)"),
        ({"interval": -5e-3}, r"`interval` must be above zero and finite"),
        ({"interval": np.full(STEPS, 5e-3)}, r"`interval` \[s\] must have the shape \(\)"),
        ({"height": -0.2}, r"`height` .* within the frame"),
        ({"substeps": 0}, r"`substeps` must be 1 or more"),
    ],
)
def test_a_linear_run_that_cannot_be_is_refused(changed, message):
    with pytest.raises(ValueError, match=message):
        linear(**changed)


def closed(**changed):
    robot = scdpr_jax.consistent()
    start = scdpr_jax.rest(robot, 0.3, 0.3, 0.5)
    given = {"reference": np.full((STEPS, 2), 0.5)} | changed
    given = {k: v if k == "delay_samples" else jnp.asarray(v) for k, v in given.items()}
    return scdpr_jax.closed_loop(robot, start, scdpr_jax.published_pd(), **given)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        (
            {"reference": np.ones((STEPS, 3))},
            r"`reference` \[m\] .* \(samples, 2\), got \(4, 3\)",
        ),
        ({"reference": np.ones((0, 2))}, r"`reference` must have one sample at least"),
        ({"feedforward": np.ones((STEPS, 1))}, r"`feedforward` \[V\] .* got \(4, 1\)"),
        ({"knock": np.ones(STEPS)}, r"`knock` \[N\] .* \(3,\), got \(4,\)"),
        ({"reference": np.full((STEPS, 2), np.nan)}, r"`reference\[0, 0\]` must be finite"),
        ({"delay_samples": -1}, r"`delay_samples` must be 0 or more"),
    ],
)
def test_a_closed_loop_that_cannot_be_is_refused(changed, message):
    with pytest.raises(ValueError, match=message):
        closed(**changed)


def test_creep_of_another_length_is_refused():
    given = call()
    robot = scdpr_jax.consistent()
    inputs = scdpr_jax.Inputs(given["duration"], given["voltage"], given["knock"])
    start = scdpr_jax.rest(robot, 0.3, 0.3, 0.5)
    with pytest.raises(ValueError, match=r"`creep` \[m\] .* \(5,\), got \(4,\)"):
        simulate_tensioned(
            Tensioner(1e4, 85.0, 0.0, 1.0), robot, start, inputs, creep=jnp.zeros(STEPS)
        )


@pytest.mark.skipif(not CASE.is_dir(), reason="the shared cases are absent")
def test_the_time_does_not_drive_a_motor():
    with pytest.raises(ValueError, match=r"`voltage` \[V\].* \(40, 2\), got \(40, 3\)"):
        runpy.run_path(str(CASE / "wide.py"))


SHAPES = ((), (1,), (2,), (3,), (5,), (STEPS,), (STEPS, 1), (STEPS, 2), (STEPS, 3), (2, STEPS))
NUMBERS = (0.0, -1.0, np.nan, np.inf, -np.inf, 1e-3, 1e30, -1e30, 5.0, 3e3, 9e5)


def hostile(random):
    """One or two arguments of another shape, or with a number in them that can't be."""
    changed = call()
    for name in random.choice(list(changed), random.integers(1, 3), replace=False):
        value = changed[name]
        if random.random() < 0.5:
            shape = SHAPES[random.integers(len(SHAPES))]
            value = np.full(shape, value.flat[0] + random.choice([0.0, 0.1]))
        else:
            value = value.copy()
            value.flat[random.integers(value.size)] = random.choice(NUMBERS)
        changed[name] = value
    return changed


def outcome(changed):
    try:
        states = run(**changed)
    except ValueError as error:
        return str(error)
    return bool(jnp.all(jnp.isfinite(states.position)))


def refusals(seed, draws):
    """Reasons of hostile draws; each either has one or gives numbers."""
    random = np.random.default_rng(seed)
    outcomes = [outcome(hostile(random)) for _ in range(draws)]
    huge = [each for each in outcomes if each is False]
    assert not huge, f"{len(huge)} of {draws} draws turned into NaN in silence"
    return [each for each in outcomes if isinstance(each, str)]


def test_hostile_draws_give_numbers_or_a_reason():
    reasons = refusals(1, 150)
    assert len(reasons) > 75
    assert all("must" in reason and "got" in reason for reason in reasons)


@pytest.mark.slow
def test_a_thousand_hostile_draws_give_numbers_or_a_reason():
    assert len(refusals(2, 1000)) > 500


@pytest.mark.parametrize("name", ["simulate", "simulate_linear", "closed_loop", "rest", "step"])
def test_what_is_refused_is_documented(name):
    assert "ValueError" in inspect.getdoc(getattr(scdpr_jax, name))
