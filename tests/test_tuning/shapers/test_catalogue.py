import hypothesis
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import strategies as st
from jax.test_util import check_grads

from scdpr_jax.command.shaper import residual_phasor, residual_vibration
from tuning.shapers.catalogue import CATALOGUE, UNITY_MAGNITUDE, damped_period, ei, zv, zvd

EPS = float(np.finfo(float).eps)
frequency = st.floats(0.5, 50)
damping = st.floats(0, 0.5)
DESIGNS = [entry.design for entry in CATALOGUE]
NAMES = [entry.name for entry in CATALOGUE]
RATIOS = jnp.linspace(0.5, 1.5, 4001)


@jax.jit
def at_nominal(shaper, frequency, damping_ratio):
    return residual_vibration(shaper, frequency=frequency, damping_ratio=damping_ratio)


@jax.jit
def slope_at_nominal(shaper, frequency, damping_ratio):
    return frequency * jax.jacfwd(
        lambda f: residual_phasor(shaper, frequency=f, damping_ratio=damping_ratio)
    )(frequency)


@jax.jit
def curve(shaper, damping_ratio):
    """Residual vibration over the ratio of the true to the design frequency, 3 Hz."""
    return jax.vmap(
        lambda ratio: residual_vibration(
            shaper, frequency=3.0 * ratio, damping_ratio=damping_ratio
        )
    )(RATIOS)


def insensitivity(shaper, damping_ratio, tolerance):
    """Width of the band of frequency ratios around 1 in which the tolerance holds."""
    within = np.asarray(curve(shaper, jnp.asarray(damping_ratio))) <= tolerance
    nominal = np.argmin(np.abs(np.asarray(RATIOS) - 1))
    low, high = nominal, nominal
    while within[low - 1]:
        low -= 1
    while within[high + 1]:
        high += 1
    return float(RATIOS[high] - RATIOS[low])


@pytest.mark.parametrize("design", [zv, zvd], ids=["zv", "zvd"])
@hypothesis.settings(max_examples=50)
@hypothesis.given(frequency=frequency, damping=damping)
def test_zero_vibration_shapers_leave_nothing_at_the_nominal_mode(design, frequency, damping):
    frequency, damping = jnp.asarray(frequency), jnp.asarray(damping)
    left = at_nominal(design(frequency, damping), frequency, damping)
    # Phases of up to 2 pi and amplitudes of sum 1, each rounded a few times.
    assert left <= 32 * EPS


@hypothesis.settings(max_examples=50)
@hypothesis.given(frequency=frequency, damping=damping)
def test_zvd_is_flat_at_the_nominal_frequency(frequency, damping):
    frequency, damping = jnp.asarray(frequency), jnp.asarray(damping)
    slope = slope_at_nominal(zvd(frequency, damping), frequency, damping)
    # As above, times a phase of 2 pi.
    assert jnp.max(jnp.abs(slope)) <= 256 * EPS


def test_zv_is_not_flat_at_the_nominal_frequency():
    mode = (jnp.asarray(3.0), jnp.asarray(0.0))
    # Two impulses of a half: pi / 2 of relative slope, on the checker of the test above.
    slope = jnp.linalg.norm(slope_at_nominal(zv(*mode), *mode))
    assert abs(float(slope) - np.pi / 2) <= 32 * EPS


def test_ei_vanishes_on_both_sides_of_the_nominal_frequency():
    left = np.asarray(curve(ei(3.0, 0.0), jnp.asarray(0.0)))
    ratios = np.asarray(RATIOS)
    # cos(pi ratio) = -(1 - V) / (1 + V), within half a grid step times the slope there.
    zero = np.arccos((1 - 0.05) / (1 + 0.05)) / np.pi
    for sign in (-1, 1):
        assert left[np.argmin(np.abs(ratios - 1 - sign * zero))] <= 0.25e-3 / 2 * np.pi


def test_undamped_ei_has_the_published_amplitudes():
    got = ei(3.0, 0.0, tolerance=0.05).amplitudes
    assert jnp.max(jnp.abs(got - jnp.array([1.05, 1.9, 1.05]) / 4)) <= 4 * EPS


@pytest.mark.parametrize("damping_ratio", [0.0, 0.02, 0.1])
def test_insensitivity_grows_from_zv_over_zvd_to_ei(damping_ratio):
    # The tolerance with room for the hump and for rounding at the nominal frequency.
    widths = [
        insensitivity(d(3.0, damping_ratio), damping_ratio, 0.0501) for d in (zv, zvd, ei)
    ]
    assert widths[0] < widths[1] < widths[2]


def test_undamped_insensitivities_are_their_closed_forms():
    # |cos(pi r / 2)| for zv, its square for zvd, from either side of r = 1.
    zv_width = 4 / np.pi * np.arcsin(0.05)
    zvd_width = 4 / np.pi * np.arcsin(np.sqrt(0.05))
    step = float(RATIOS[1] - RATIOS[0])
    assert abs(insensitivity(zv(3.0, 0.0), 0.0, 0.05) - zv_width) <= 2 * step
    assert abs(insensitivity(zvd(3.0, 0.0), 0.0, 0.05) - zvd_width) <= 2 * step


@pytest.mark.parametrize("entry", [*CATALOGUE, *UNITY_MAGNITUDE], ids=lambda entry: entry.name)
def test_durations_without_damping_are_those_of_the_catalogue(entry):
    expected = entry.periods / 3.0
    # The catalogue has four digits where there is no fraction.
    assert abs(float(entry.design(3.0, 0.0).duration) - expected) <= 1e-4 / 3


@pytest.mark.parametrize("entry", CATALOGUE, ids=NAMES)
def test_durations_with_damping_stay_within_two_percent_of_their_periods(entry):
    expected = entry.periods * float(damped_period(3.0, 0.1))
    assert abs(float(entry.design(3.0, 0.1).duration) / expected - 1) <= 0.02


def test_catalogue_holds_the_shapers_of_the_literature():
    names = {"zv", "mzv", "zvd", "ei", "zvdd", "2hump_ei", "3hump_ei"}
    assert set(NAMES) == names
    assert {entry.name for entry in UNITY_MAGNITUDE} == {"um_zv", "um_ei"}


@pytest.mark.parametrize("design", DESIGNS, ids=NAMES)
@hypothesis.settings(max_examples=30)
@hypothesis.given(frequency=frequency, damping=st.floats(0, 0.2))
def test_amplitudes_are_positive_and_sum_to_one(design, frequency, damping):
    amplitudes = design(frequency, damping).amplitudes
    assert jnp.min(amplitudes) > 0
    assert abs(float(jnp.sum(amplitudes)) - 1) <= 8 * EPS


@pytest.mark.parametrize("design", DESIGNS, ids=NAMES)
@pytest.mark.parametrize("mode", [(0.0, 0.1), (3.0, 1.0), (3.0, -0.1)])
def test_a_mode_that_does_not_vibrate_is_refused_and_has_no_shaper_under_jit(design, mode):
    with pytest.raises(ValueError, match="a mode that doesn't vibrate needs no shaper"):
        design(*mode)
    build = jax.jit(lambda frequency, ratio: design(frequency, ratio).times)
    assert jnp.all(jnp.isnan(build(*map(jnp.asarray, mode))))


@pytest.mark.parametrize(
    "design",
    [
        # Compiling the derivatives of those with humps takes a quarter of a minute each.
        pytest.param(design, id=name, marks=[pytest.mark.slow] if "hump" in name else [])
        for name, design in zip(NAMES, DESIGNS, strict=True)
    ],
)
def test_shapers_are_differentiable_in_their_mode(design):
    def impulses(frequency, damping_ratio):
        shaper = design(frequency, damping_ratio)
        return jnp.stack([shaper.times, shaper.amplitudes])

    arguments = (jnp.asarray(3.0), jnp.asarray(0.1))
    check_grads(jax.jit(impulses), arguments, order=1, modes=("fwd", "rev"))


@pytest.mark.parametrize("design", DESIGNS, ids=NAMES)
def test_shapers_batch_over_modes(design):
    frequencies, ratios = jnp.array([2.0, 3.0]), jnp.array([0.0, 0.1])
    batch = jax.jit(jax.vmap(design))(frequencies, ratios)
    one = design(3.0, 0.1)
    assert jnp.max(jnp.abs(batch.times[1] - one.times)) <= 4 * EPS
    assert jnp.max(jnp.abs(batch.amplitudes[1] - one.amplitudes)) <= 4 * EPS
