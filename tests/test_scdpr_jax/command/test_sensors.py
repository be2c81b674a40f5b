import hypothesis
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import strategies as st

from scdpr_jax.command.sensors import (
    Camera,
    Encoder,
    encoder_counts,
    frame_times,
    observe,
    read_encoder,
)

ENCODER = Encoder()
COUNT = 2 * np.pi / 26624
EPS = float(np.finfo(float).eps)
angle = st.floats(-100, 100)
POSITIONS = jnp.tile(jnp.array([0.3, 0.01, 0.29, 0.31, 0.55]), (4000, 1))


@jax.jit
def seen_by(camera, key):
    return observe(camera, POSITIONS, key=key)


@jax.jit
def fifty_frames(camera, key):
    return frame_times(camera, count=50, key=key)


@hypothesis.given(first=angle, second=angle)
def test_encoder_is_within_half_a_count(first, second):
    angles = jnp.array([first, second])
    error = read_encoder(ENCODER, angles) - angles
    # Roundings of an angle of up to 100 rad beside the half count.
    assert jnp.max(jnp.abs(error)) <= COUNT / 2 + 8 * EPS * 100


@hypothesis.given(first=angle, second=angle)
def test_encoder_counts_are_whole_numbers(first, second):
    counts = encoder_counts(ENCODER, jnp.array([first, second]))
    assert jnp.array_equal(counts, jnp.round(counts))


def test_one_turn_is_the_counts_of_a_turn():
    counts = encoder_counts(ENCODER, jnp.array([2 * jnp.pi, -jnp.pi]))
    assert jnp.array_equal(counts, jnp.array([26624.0, -13312.0]))


def test_quantisation_scatters_like_the_rigs_encoder_sigma():
    angles = jnp.linspace(0.0, 1.0, 20001)
    read = jax.vmap(lambda angle: read_encoder(ENCODER, jnp.stack([angle, angle])))(angles)
    # A count over sqrt(12): the campaigns give 0.068 mrad, two digits.
    assert abs(float(jnp.std(read[:, 0] - angles)) - 0.068e-3) <= 0.0005e-3


@pytest.mark.parametrize("derivative", [jax.jacfwd, jax.jacrev])
def test_encoder_derivative_goes_straight_through(derivative):
    jacobian = jax.jit(derivative(lambda angles: read_encoder(ENCODER, angles)))
    # The count's factor and its reciprocal: two roundings.
    assert jnp.max(jnp.abs(jacobian(jnp.array([0.3, -1.7])) - jnp.eye(2))) <= 4 * EPS


def test_encoder_batches_under_jit():
    angles = jax.random.normal(jax.random.key(1), (7, 2))
    batch = jax.jit(jax.vmap(lambda pair: read_encoder(ENCODER, pair)))(angles)
    single = jnp.stack([read_encoder(ENCODER, pair) for pair in angles])
    # Fused or not, the scaling may round differently.
    assert jnp.max(jnp.abs(batch - single)) <= 8 * EPS * 10


def test_frames_without_jitter_are_evenly_spaced():
    times = frame_times(Camera(), count=91, key=jax.random.key(0), start=0.5)
    # A product and a sum of up to 3.5 s.
    assert np.max(np.abs(np.asarray(times) - 0.5 - np.arange(91) / 30)) <= 8 * EPS * 3.5


@hypothesis.given(jitter=st.floats(0, 1), seed=st.integers(0, 2**31 - 1))
def test_frames_never_change_places(jitter, seed):
    times = fifty_frames(Camera(jitter=jitter), jax.random.key(seed))
    assert jnp.min(jnp.diff(times)) > 0


def test_frames_scatter_by_the_jitter():
    times = frame_times(Camera(jitter=0.8e-3), count=4000, key=jax.random.key(0))
    scatter = jnp.std(times - jnp.arange(4000) / 30)
    # Five standard errors of a standard deviation, sigma / sqrt(2 n).
    assert jnp.abs(scatter - 0.8e-3) <= 5 * 0.8e-3 / np.sqrt(8000)


def test_camera_noise_has_the_sigma_of_each_coordinate():
    seen = seen_by(Camera(), jax.random.key(2))
    sigma = jnp.array([0.19e-3, 2e-3, 0.19e-3, 0.19e-3, 0.19e-3])
    relative = jnp.std(seen - POSITIONS, axis=0) / sigma
    # Five standard errors of a standard deviation.
    assert jnp.max(jnp.abs(relative - 1)) <= 5 / np.sqrt(8000)


def test_camera_noise_is_unbiased():
    seen = seen_by(Camera(), jax.random.key(3))
    sigma = jnp.array([0.19e-3, 2e-3, 0.19e-3, 0.19e-3, 0.19e-3])
    assert jnp.max(jnp.abs(jnp.mean(seen - POSITIONS, axis=0)) / sigma) <= 5 / np.sqrt(4000)


def test_lost_markers_are_nan_at_their_probability():
    seen = seen_by(Camera(loss_probability=0.02), jax.random.key(4))
    share = float(jnp.mean(jnp.isnan(seen)))
    # Five standard errors of a share of 20000 cells.
    assert abs(share - 0.02) <= 5 * np.sqrt(0.02 * 0.98 / 20000)


def test_the_same_key_gives_the_same_record():
    camera = Camera(loss_probability=0.1)
    one, two = (seen_by(camera, jax.random.key(5)) for _ in range(2))
    assert jnp.array_equal(one, two, equal_nan=True)


def test_camera_is_differentiable_where_the_marker_was_seen():
    camera = Camera(loss_probability=0.5)
    key = jax.random.key(6)
    record = jax.jit(lambda positions: observe(camera, positions, key=key))
    seen, slope = jax.jvp(record, (POSITIONS,), (jnp.ones_like(POSITIONS),))
    assert jnp.array_equal(slope, jnp.where(jnp.isnan(seen), 0.0, 1.0))


def test_camera_batches_over_keys():
    keys = jax.random.split(jax.random.key(7), 3)
    batch = jax.jit(jax.vmap(lambda key: observe(Camera(), POSITIONS, key=key)))(keys)
    assert jnp.array_equal(batch[1], seen_by(Camera(), keys[1]))
