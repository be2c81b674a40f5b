import hypothesis
import jax
import jax.numpy as jnp
import numpy as np
from hypothesis import strategies as st
from jax.test_util import check_grads

from scdpr_jax.robot.drive import (
    drive_gain,
    drive_pole,
    motor_current,
    motor_torque,
    transfer_function,
)
from scdpr_jax.robot.prototype import consistent, published
from scdpr_jax.robot.quantities import replace

EPS = float(np.finfo(float).eps)
DRIVE = consistent().drive


@jax.jit
def response(drive, angular_frequency):
    return transfer_function(drive).response(angular_frequency)


def test_consistent_drive_has_the_printed_gain_in_degrees():
    # Four printed digits.
    assert abs(float(transfer_function(DRIVE).gain_in_degrees) - 2169) <= 0.5


def test_consistent_drive_has_the_printed_pole():
    # 16.68 is printed to two decimals; b to four digits moves the pole by 0.004.
    assert abs(float(drive_pole(DRIVE)) - 16.68) <= 0.005


def test_the_printed_numerator_is_not_one_over_the_inertia():
    printed = 1 / DRIVE.inertia
    assert jnp.abs(printed - transfer_function(DRIVE).gain_in_degrees) > 2000


def test_gain_is_the_angular_acceleration_of_one_volt():
    torque = motor_torque(DRIVE, jnp.asarray(1.0))
    assert jnp.allclose(drive_gain(DRIVE), torque / DRIVE.inertia, rtol=4 * EPS, atol=0)


@hypothesis.given(st.floats(1e-3, 1e4), st.floats(1e-3, 0.1), st.floats(1e-3, 2.0))
def test_response_times_its_denominator_is_the_gain(frequency, inertia, damping):
    robot = replace(consistent(), {"drive_inertia": inertia, "drive_damping": damping})
    s = 1j * frequency
    gain, pole = 0.482 / inertia, damping / inertia
    product = complex(response(robot.drive, jnp.asarray(frequency))) * s * (s + pole)
    # Some ten roundings of the modulus.
    assert abs(product - gain) <= 16 * EPS * gain


def test_response_takes_an_array_of_frequencies():
    frequencies = jnp.array([1.0, 40.0])
    both = response(DRIVE, frequencies)
    assert jnp.array_equal(both[1], response(DRIVE, frequencies[1]))


def test_response_is_differentiable_in_the_drive():
    # Relative changes, so that the checker's difference step fits both.
    def parts(inertia, damping):
        numbers = {"drive_inertia": 0.0127 * inertia, "drive_damping": 0.21 * damping}
        found = response(replace(consistent(), numbers).drive, jnp.asarray(40.0))
        return found.real, found.imag

    arguments = (jnp.asarray(1.0), jnp.asarray(1.0))
    check_grads(jax.jit(parts), arguments, order=1, modes=("fwd", "rev"))


def test_nameplate_current_is_six_amperes_at_the_limit():
    # 10 V and 0.6 A/V, section 5.1; a few roundings.
    current = motor_current(published().drive, jnp.array([10.0, -10.0]))
    assert jnp.allclose(current, jnp.array([6.0, -6.0]), rtol=8 * EPS, atol=0)


@hypothesis.given(st.floats(10.0, 1e3))
def test_command_beyond_the_limit_gives_the_limits_torque(voltage):
    assert motor_torque(DRIVE, jnp.asarray(voltage)) == 10.0 * DRIVE.torque_per_volt
    assert motor_torque(DRIVE, jnp.asarray(-voltage)) == -10.0 * DRIVE.torque_per_volt
