"""Plant and controller as objects of python-control, the extra `control`."""

from typing import TYPE_CHECKING, NamedTuple

from tuning.export.description import describe
from tuning.result.tuning import Tuning

if TYPE_CHECKING:
    import control


class ControlObjects(NamedTuple):
    """A tuned drive for python-control."""

    plant: "control.TransferFunction"
    """The bare drive, Eq. (24), continuous: command [V] to angle [rad]."""
    controller: "control.TransferFunction"
    """The PD, sampled: error [rad] to command [V]."""


def control_objects(tuning: Tuning) -> ControlObjects:
    r"""The plant and the sampled controller as `control.TransferFunction`.

    $$ G(s) = \frac{g}{s (s + p)}, \qquad
       R(z) = \frac{(K_p (\tau + h) + K_d) z - (K_p \tau + K_d)}{(\tau + h) z - \tau} $$

    Args:
        tuning: The tuning.

    Returns:
        Both; sample the plant with `control.sample_system(plant, controller.dt, "zoh")`.

    Raises:
        ImportError: If python-control isn't installed.
        ValueError: If the tuning has no fitted robot, or no shaper.
    """
    try:
        import control
    except ImportError as error:
        raise ImportError(
            "`control_objects` needs python-control, which isn't installed: install "
            "scdpr-jax[control]."
        ) from error
    description = describe(tuning)
    constants, plant = description.constants, description.plant
    kept, interval = constants.filter_time, constants.filter_time + constants.period
    proportional, derivative = constants.proportional_gain, constants.derivative_gain
    return ControlObjects(
        plant=control.TransferFunction([float(plant.gain)], [1.0, float(plant.pole), 0.0]),
        controller=control.TransferFunction(
            [proportional * interval + derivative, -(proportional * kept + derivative)],
            [interval, -kept],
            constants.period,
        ),
    )
