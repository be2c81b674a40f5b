"""What a fit is free to change: the robot's named quantities and each run's circumstances.

Within a fit a quantity that must be positive is its logarithm, so that a step is a ratio;
one that may be zero is itself, with zero as its bound.
"""

import dataclasses
import math
from collections.abc import Sequence

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from identification.campaign.types import Run
from identification.data.circumstances import (
    BEGINNING,
    NAMES,
    Circumstances,
    names_of,
    open_circumstances,
)
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.quantities import quantity, replace, value

PER_SETTING = "effective_pretension"
"""The quantity that every nominal pretension has its own value of."""

DEFAULT_FREE = (
    "friction_coefficient",
    "drive_inertia",
    "drive_damping",
    "drive_friction",
    "effective_pretension",
)
"""What is estimated unless the caller chooses otherwise: no drive is without dry friction, and
where it is left out the carriages' takes it up."""

FARTHEST = 3.0
"""Longest step of a logarithm [1]: twenty times as much is beyond what slopes tell."""

FOLLOWS = {"upper_friction_coefficient": "friction_coefficient"}
"""Quantities that have the value of another one as long as they aren't free."""


@dataclasses.dataclass(frozen=True)
class Unknowns:
    """The layout of a fit's vector: shared quantities first, then each run's own."""

    free: tuple[str, ...]
    """Names of the free quantities."""
    shared: tuple[tuple[str, str | None], ...]
    """Name and pretension setting of each shared unknown."""
    local: Int[np.ndarray, "runs names"]
    """Which shared unknown each run's free quantity is."""
    active: Bool[np.ndarray, "runs circumstances"]
    """Which circumstances each run leaves open."""
    opened: Bool[np.ndarray, " shared"]
    """Which shared unknowns the fit may change; the others keep their values."""

    @property
    def opened_names(self) -> tuple[tuple[str, str | None], ...]:
        """Name and pretension setting of each shared unknown that the fit may change."""
        return tuple(self.shared[index] for index in np.flatnonzero(self.opened))

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return len(self.shared) + self.active.size

    def place(self, name: str, setting: str | None = None) -> int:
        """Where a shared quantity stands in the vector.

        Args:
            name: Its name.
            setting: The nominal pretension that it belongs to, None for all.

        Returns:
            Its index.
        """
        return self.shared.index((name, setting))

    def circumstances(self, run: int) -> Int[np.ndarray, " circumstances"]:
        """Where a run's circumstances stand in the vector.

        Args:
            run: The run's number.

        Returns:
            Indices in the order of `identification.data.circumstances.names_of`.
        """
        count = self.active.shape[1]
        return len(self.shared) + count * run + np.arange(count)

    def circumstance(self, run: int, name: str) -> int:
        """Where one of a run's circumstances stands in the vector.

        Args:
            run: The run's number.
            name: Name of the circumstance.

        Returns:
            Its index.
        """
        return int(self.circumstances(run)[(*NAMES, *BEGINNING).index(name)])

    def of_run(self, run: int) -> Int[np.ndarray, " of_run"]:
        """Where a run's quantities and circumstances stand in the vector.

        Args:
            run: The run's number.

        Returns:
            Indices, quantities first.
        """
        return np.concatenate([self.local[run], self.circumstances(run)])

    def of_bare(self, run: int) -> Int[np.ndarray, " of_run"]:
        """Where the quantities of a run of the bare drives stand in the vector.

        Args:
            run: The run's number.

        Returns:
            Indices of the quantities; circumstances follow where runs begin in motion.
        """
        in_motion = self.active.shape[1] > len(NAMES)
        return self.of_run(run) if in_motion else self.local[run]

    def open_to(self, runs: Sequence[int]) -> Bool[np.ndarray, " size"]:
        """Which unknowns a fit of some runs may change.

        Args:
            runs: Their numbers.

        Returns:
            True for the opened quantities and for the circumstances that these runs leave open.
        """
        fitted = np.isin(np.arange(len(self.active)), runs)
        return np.concatenate([self.opened, (self.active & fitted[:, None]).ravel()])

    def lower(self) -> Float[np.ndarray, " size"]:
        """Lower bounds of the vector.

        Returns:
            Zero for a quantity that may be zero, minus infinity for everything else.
        """
        of_shared = [lower_bound(name) for name, _ in self.shared]
        return np.concatenate([of_shared, np.full(self.active.size, -np.inf)])

    def longest(self) -> Float[np.ndarray, " size"]:
        """Longest step of each number of the vector.

        Returns:
            `FARTHEST` for a quantity that is held as its logarithm, infinity for all else.
        """
        positive = np.array([quantity(name).positive for name, _ in self.shared])
        of_shared = np.where(positive, FARTHEST, np.inf)
        return np.concatenate([of_shared, np.full(self.active.size, np.inf)])


def layout(
    runs: Sequence[Run],
    free: tuple[str, ...],
    *,
    opened: Sequence[str] | None = None,
    clock_drifts: bool = False,
) -> Unknowns:
    """The unknowns of a set of runs.

    Args:
        runs: The runs to fit.
        free: Names of the quantities to estimate.
        opened: Those of them that a fit may change, None for all: models that free
            different quantities then share what is compiled for `free`. The upper
            carriage's friction, if it isn't opened, follows the lower one's.
        clock_drifts: Whether the cameras' clocks may drift.

    Returns:
        Their layout; motor steps leave no circumstances open but what they begin with.

    Raises:
        ValueError: If a name is unknown or stands twice.
    """
    for name in free:
        quantity(name)
    if len(set(free)) != len(free):
        raise ValueError(f"`free` names a quantity twice, got {', '.join(free)}.")
    cabled = [run for run in runs if run.kind != "motor_step"] or runs
    settings = sorted({(run.pretension, run.pretension_label) for run in cabled})
    chosen = free if opened is None else tuple(opened)
    followed = {
        follower: leader
        for follower, leader in FOLLOWS.items()
        if follower in free and follower not in chosen and leader in free
    }
    shared: list[tuple[str, str | None]] = []
    for name in free:
        if name == PER_SETTING:
            shared.extend((name, label) for _, label in settings)
        elif name not in followed:
            shared.append((name, None))
    labels = {label for _, label in settings}

    def setting(run: Run, name: str) -> str | None:
        if name != PER_SETTING:
            return None
        # Without the cable any setting will do: the run doesn't depend on it.
        return run.pretension_label if run.pretension_label in labels else settings[0][1]

    local = [
        [shared.index((followed.get(name, name), setting(run, name))) for name in free]
        for run in runs
    ]
    in_motion = any(run.in_motion for run in runs)
    return Unknowns(
        free=free,
        shared=tuple(shared),
        local=np.array(local, dtype=int).reshape(len(runs), len(free)),
        active=np.array(
            [
                open_circumstances(run, clock_drifts=clock_drifts, in_motion=in_motion)
                for run in runs
            ]
        ).reshape(len(runs), len(names_of(in_motion=in_motion))),
        opened=np.array([name in chosen for name, _ in shared], dtype=bool),
    )


def lower_bound(name: str) -> float:
    """Least value of a quantity as a fit holds it.

    Args:
        name: Name of the quantity.

    Returns:
        Zero for a quantity that may be zero and isn't signed, else minus infinity.
    """
    return -math.inf if quantity(name).positive or quantity(name).signed else 0.0


def encode(name: str, number: float) -> float:
    """A quantity's value as a fit holds it.

    Args:
        name: Name of the quantity.
        number: Its value [SI].

    Returns:
        Its logarithm if it must be positive, else itself.
    """
    return math.log(number) if quantity(name).positive else float(number)


def decode(name: str, encoded: float) -> float:
    """A quantity's value from how a fit holds it, the inverse of `encode`.

    Args:
        name: Name of the quantity.
        encoded: What the fit holds.

    Returns:
        Its value [SI].
    """
    return math.exp(encoded) if quantity(name).positive else float(encoded)


def apply(robot: Robot, free: tuple[str, ...], encoded: Float[Array, " names"]) -> Robot:
    """The robot with the free quantities that a fit's vector stands for.

    Args:
        robot: The robot to start from.
        free: Names of the free quantities.
        encoded: Their values as the fit holds them.

    Returns:
        The robot with these values.
    """
    values = {
        name: jnp.exp(number) if quantity(name).positive else number
        for name, number in zip(free, encoded, strict=True)
    }
    return replace(robot, values)


def apply_run(
    robot: Robot, free: tuple[str, ...], unknown: Float[Array, " of_run"]
) -> tuple[Robot, Circumstances]:
    """The robot and the circumstances that a run's part of a fit's vector stands for.

    Args:
        robot: The robot to start from.
        free: Names of the free quantities.
        unknown: Free quantities as the fit holds them, then the run's circumstances.

    Returns:
        The robot with these values, and the run's circumstances.
    """
    count = len(free)
    return apply(robot, free, unknown[:count]), Circumstances.of(unknown[count:])


def start_values(robot: Robot, unknowns: Unknowns) -> Float[np.ndarray, " shared"]:
    """The robot's own values of the shared unknowns, as a fit holds them.

    Args:
        robot: The robot.
        unknowns: The layout.

    Returns:
        Encoded values of the shared unknowns.
    """
    numbers = [encode(name, float(value(robot, name))) for name, _ in unknowns.shared]
    return np.array(numbers, dtype=float)
