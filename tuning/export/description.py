"""What is exported of a tuning, whatever the format."""

import dataclasses

import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.provenance import UNKNOWN, Provenance
from scdpr_jax.robot.drive import drive_gain, drive_pole
from scdpr_jax.robot.fields import si
from tuning.loop.plant import MotorPlant
from tuning.result.regional_shaper import RegionalShaper
from tuning.result.tuning import Tuning


@dataclasses.dataclass(frozen=True)
class Constants:
    """The numbers of the sampled controller; a format names and documents them by field."""

    proportional_gain: float = dataclasses.field(metadata=si("V/rad", "K_p"))
    """Proportional gain of the PD, Eq. (23) [V/rad]."""
    derivative_gain: float = dataclasses.field(metadata=si("V s/rad", "K_d"))
    """Its derivative gain [V s/rad]."""
    period: float = dataclasses.field(metadata=si("s", "h"))
    """Sample period of the controller and of the shaped reference [s]."""
    filter_time: float = dataclasses.field(metadata=si("s", r"\tau"))
    """Time constant of the derivative's filter [s], 0 for none."""
    voltage_limit: float = dataclasses.field(metadata=si("V", "V_{max}"))
    """Largest command of either sign [V]."""
    effective_radius: float = dataclasses.field(metadata=si("m", "r"))
    """Effective radius of the driver pulleys, Eq. (3) [m]."""


@dataclasses.dataclass(frozen=True, eq=False)
class Description:
    """A tuning as a controller's programmer needs it."""

    constants: Constants
    """The controller's numbers."""
    plant: MotorPlant
    """The bare drive, Eq. (24)."""
    shapers: tuple[RegionalShaper, ...]
    """The shapers, each for legs that end in its region; the first that fits counts."""
    caution: str = ""
    """What every file has to warn of; empty for nothing."""
    provenance: Provenance = UNKNOWN
    """Where it comes from."""


def describe(tuning: Tuning) -> Description:
    """What is exported of a tuning.

    The drives are those of its first fitted robot: settings differ in the cable only.

    Args:
        tuning: The tuning.

    Returns:
        The description.

    Raises:
        ValueError: If the tuning has no fitted robot, or no shaper.
    """
    drive = tuning.robot_at().robot.drive
    if not tuning.shapers:
        raise ValueError(
            "the tuning has no shaper, got none to export, expected one for each region. "
            "Write tuning.json anew with `scdpr tune` or `scdpr calibrate`."
        )
    controller = tuning.controller
    return Description(
        constants=Constants(
            proportional_gain=float(controller.proportional_gain),
            derivative_gain=float(controller.derivative_gain),
            period=float(controller.period),
            filter_time=float(controller.filter_time),
            voltage_limit=float(drive.voltage_limit),
            effective_radius=float(drive.effective_radius),
        ),
        plant=MotorPlant(gain=drive_gain(drive), pole=drive_pole(drive)),
        shapers=tuning.shapers,
        caution=tuning.caution,
        provenance=tuning.provenance,
    )


def decimal(number: float | Float[Array, ""]) -> str:
    """A number as a plain decimal, without an exponent, that reads back to the same bits.

    LabVIEW's spreadsheet readers, C and MATLAB all take it.

    Args:
        number: A finite number.

    Returns:
        Its shortest such text, with a decimal point and a digit on either side.
    """
    return np.format_float_positional(float(number), unique=True, trim="0")
