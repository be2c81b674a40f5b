"""Tests of `scdpr_jax.numerics.batches`."""

import json
import os
import subprocess
import sys

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from scdpr_jax.linear.modes import CONDITIONS, natural_frequencies
from scdpr_jax.numerics.batches import chunks, in_chunks
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace


def frequencies(point):
    """Frequencies at a height and a pretension, under every condition of the carriages."""
    height, pretension = point
    robot = replace(consistent(), {"effective_pretension": pretension})
    return jnp.concatenate([natural_frequencies(robot, height, each) for each in CONDITIONS])


def grid(count):
    """Heights [m] and pretensions [N]."""
    random = np.random.default_rng(3)
    return random.uniform(0.2, 0.9, count), random.uniform(50.0, 300.0, count)


@pytest.mark.parametrize("count", [1, 7, 8, 9, 40])
def test_a_point_gives_the_same_bits_whatever_the_batch(count):
    points = grid(40)
    whole = in_chunks(frequencies, points, size=8)
    part = in_chunks(frequencies, tuple(leaf[-count:] for leaf in points), size=8)
    np.testing.assert_array_equal(part, whole[-count:])


def test_results_are_those_of_the_function_itself():
    points = grid(11)
    found = in_chunks(frequencies, points, size=4)
    for row, point in enumerate(zip(*points, strict=True)):
        alone = frequencies(tuple(jnp.asarray(number) for number in point))
        # A few ulp: the batched eigenvalues are compiled apart.
        np.testing.assert_allclose(found[row], alone, rtol=1e-13)


def test_another_length_compiles_nothing_anew():
    traces = []

    def counted(point):
        traces.append(1)
        return 2 * point

    for count in (3, 8, 20):
        in_chunks(counted, np.arange(count, dtype=float), size=8)
    assert len(traces) == 1


def test_results_keep_their_structure_and_dtype():
    found = in_chunks(lambda x: {"half": x / 2, "is": x > 1}, np.float32([1, 2, 3]), size=2)
    assert found["half"].dtype == np.float32
    np.testing.assert_array_equal(found["is"], [False, True, True])


def test_chunks_come_in_order_and_the_last_one_is_what_is_left():
    devices = jax.devices()[:1]
    found = list(chunks(jnp.negative, np.arange(5.0), size=2, devices=devices))
    assert [list(chunk) for chunk in found] == [[0, -1], [-2, -3], [-4]]


_ON_DEVICES = """
import json, sys, jax
jax.config.update("jax_enable_x64", True)
sys.path.insert(0, sys.argv[1])
from test_batches import frequencies, grid
from scdpr_jax.numerics.batches import in_chunks
found = in_chunks(frequencies, grid(50), size=8)
print(json.dumps([jax.device_count(), found.tobytes().hex()]))
"""


def test_two_devices_give_the_bits_of_one():
    flags = "--xla_force_host_platform_device_count=2"
    done = subprocess.run(
        [sys.executable, "-c", _ON_DEVICES, os.path.dirname(__file__)],
        env={**os.environ, "XLA_FLAGS": flags},
        capture_output=True,
        text=True,
        check=True,
    )
    devices, bits = json.loads(done.stdout)
    assert devices == 2
    assert bytes.fromhex(bits) == in_chunks(frequencies, grid(50), size=8).tobytes()


@pytest.mark.parametrize("points", [np.zeros((0, 2)), (np.zeros(2), np.zeros(3)), np.zeros(())])
def test_points_of_no_common_length_are_named(points):
    with pytest.raises(ValueError, match="`points` must be arrays of one length"):
        in_chunks(lambda point: point, points, size=2)


def test_a_size_of_no_point_is_refused():
    with pytest.raises(ValueError, match="`size` must be 1 or more"):
        in_chunks(lambda point: point, np.zeros(3), size=0)


_PEAK = """
import resource, sys
import numpy as np
sys.path.insert(0, sys.argv[1])
from test_batches import frequencies
from scdpr_jax.numerics.batches import chunks
count = int(sys.argv[2])
points = np.linspace(0.2, 0.9, count, dtype=np.float32), np.full(count, 85, np.float32)
largest = max(float(chunk.max()) for chunk in chunks(frequencies, points, size=16384))
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


@pytest.mark.slow
def test_memory_stays_flat_to_a_million_points():
    def peak(count):
        command = [sys.executable, "-c", _PEAK, os.path.dirname(__file__), str(count)]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        return int(done.stdout)  # [KiB]

    # The points themselves are 8 MB; a million results at once with their work would be more.
    assert peak(1_000_000) - peak(100_000) < 40_000
