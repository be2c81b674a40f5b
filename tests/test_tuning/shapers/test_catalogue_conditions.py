"""Each shaper of the catalogue against the equations that define it."""

import itertools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.optimize import least_squares, minimize_scalar

from scdpr_jax.command.shaper import residual_phasor, residual_vibration
from tuning.shapers.catalogue import (
    ei,
    mzv,
    three_hump_ei,
    two_hump_ei,
    um_ei,
    um_zv,
    zv,
    zvd,
    zvdd,
)

# Conditions are solved to 1e-11 or to rounding; this is what the catalogue promises.
PROMISED = 1e-10
EXTRA_INSENSITIVE = [(ei, 1), (two_hump_ei, 2), (three_hump_ei, 3)]
RATIOS = [0.0, 0.01, 0.05, 0.1, 0.2]


@jax.jit
def phasor(shaper, frequency, ratio):
    return residual_phasor(shaper, frequency=frequency, damping_ratio=ratio)


@jax.jit
def left(shaper, frequencies, ratio):
    return jax.vmap(lambda f: residual_vibration(shaper, frequency=f, damping_ratio=ratio))(
        frequencies
    )


def zeros_and_humps(shaper, nominal, ratio):
    """Frequencies at which the curve vanishes, and heights and places of the maxima between."""
    frequency = np.linspace(0.2, 1.8, 3201) * nominal
    curve = np.asarray(left(shaper, jnp.asarray(frequency), jnp.asarray(ratio)))
    low = np.flatnonzero((curve[1:-1] < curve[:-2]) & (curve[1:-1] <= curve[2:])) + 1
    zeros = []
    for place in low:
        found = least_squares(
            lambda f: np.asarray(phasor(shaper, jnp.asarray(f[0]), jnp.asarray(ratio))),
            [frequency[place]],
            xtol=1e-15,
            ftol=1e-15,
            gtol=1e-15,
        )
        if np.linalg.norm(found.fun) <= PROMISED:
            zeros.append(float(found.x[0]))
    humps = []
    for a, b in itertools.pairwise(zeros):
        found = minimize_scalar(
            lambda f: -float(left(shaper, jnp.asarray([f]), jnp.asarray(ratio))[0]),
            bounds=(a, b),
            method="bounded",
            options={"xatol": 1e-9 * nominal},
        )
        humps.append((float(found.x), -found.fun))
    return zeros, humps


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("design", [zv, zvd, zvdd, mzv, um_zv], ids=lambda d: d.__name__)
@pytest.mark.parametrize("frequency", [0.3, 3.0, 200.0])
def test_zero_vibration_shapers_leave_nothing(design, ratio, frequency):
    parts = phasor(design(frequency, ratio), jnp.asarray(frequency), jnp.asarray(ratio))
    assert jnp.linalg.norm(parts) <= PROMISED


@pytest.mark.parametrize("ratio", RATIOS)
def test_zvdd_has_two_derivatives_of_zero(ratio):
    shaper = zvdd(3.0, ratio)
    along = jax.jacfwd(lambda f: phasor(shaper, 3.0 * f, jnp.asarray(ratio)))
    for derivative in (along, jax.jacfwd(along)):
        assert jnp.linalg.norm(derivative(jnp.asarray(1.0))) <= PROMISED


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize(("design", "humps"), EXTRA_INSENSITIVE, ids=["ei", "2", "3"])
def test_extra_insensitive_shapers_have_their_zeros_and_humps(design, humps, ratio):
    shaper = design(3.0, ratio)
    assert abs(float(jnp.sum(shaper.amplitudes)) - 1) <= PROMISED
    zeros, hills = zeros_and_humps(shaper, 3.0, ratio)
    assert len(zeros) == humps + 1
    for _, height in hills:
        # A maximum found to 1e-9 of the frequency is exact to that squared.
        assert abs(height - 0.05) <= PROMISED
    middle = [f for f, _ in hills][humps // 2] if humps % 2 else zeros[(humps + 1) // 2]
    # A flat maximum is found to the root of the rounding.
    assert abs(middle - 3.0) <= 1e-6


@pytest.mark.parametrize("ratio", RATIOS)
def test_unity_magnitude_ei_has_its_zeros_and_hump(ratio):
    shaper = um_ei(3.0, ratio)
    assert shaper.amplitudes.tolist() == [1.0, -1.0, 1.0, -1.0, 1.0]
    assert abs(float(left(shaper, jnp.array([3.0]), jnp.asarray(ratio))[0]) - 0.05) <= PROMISED
    zeros, hills = zeros_and_humps(shaper, 3.0, ratio)
    assert len([f for f in zeros if abs(f - 3.0) < 1.2]) == 2
    assert min(abs(height - 0.05) for _, height in hills) <= PROMISED


def test_a_shaper_that_misses_its_conditions_is_noticed():
    # The checker on ZVD, which has one zero, and no hump of 5 %.
    zeros, _ = zeros_and_humps(zvd(3.0, 0.05), 3.0, 0.05)
    assert len(zeros) != 2


def test_two_hump_ei_agrees_with_the_published_fit():
    # Singhose, Porter, Tuttle and Singer 1997, V = 5 %: cubic fits, good to some 1e-3.
    z = 0.1
    shaper = two_hump_ei(1.0, z)
    amplitudes = [
        0.16054 + 0.76699 * z + 2.26560 * z**2 - 1.22750 * z**3,
        0.33911 + 0.45081 * z - 2.58080 * z**2 + 1.73650 * z**3,
    ]
    assert np.max(np.abs(np.asarray(shaper.amplitudes[:2]) - amplitudes)) <= 1e-3


@pytest.mark.parametrize(("design", "humps"), EXTRA_INSENSITIVE, ids=["ei", "2", "3"])
def test_more_damping_than_a_hump_survives_is_refused(design, humps):
    if humps == 1:
        pytest.skip("one hump exists at any damping ratio that vibrates")
    with pytest.raises(ValueError, match="couldn't be solved for"):
        design(3.0, 0.45)


def test_mzv_tolerates_more_than_zv_and_less_than_zvd():
    off = jnp.array([0.95 * 3.0])
    each = [
        float(left(design(3.0, 0.05), off, jnp.asarray(0.05))[0]) for design in (zv, mzv, zvd)
    ]
    assert each[0] > each[1] > each[2]
