r"""Combinations of quantities that measurements tell, and those that they don't.

Let $J$ be the derivatives of what is measured with respect to quantities in units of what is
plausible of each: a factor of $e$ of what must be positive, the drive's whole force for a
friction. Its right singular vectors are combinations that move what is measured independently,
and its singular values say by how much. A combination isn't told where all that is plausible
of it moves less than a thousandth of the motion: then the model's own error decides, and no
smaller noise helps. It isn't told either where the noise hides it. An error that is scaled by
the residuals says neither: it shrinks with them, whatever the rank.
"""

import dataclasses

import numpy as np
from jaxtyping import Float

DETERMINED = 0.1
"""Standard error over what is plausible up to which a combination counts as told [1]."""

SHARE = 1e-3
"""Share of the motion that a told combination moves over all that is plausible of it [1]."""

NOTABLE_PART = 0.2
"""Part of a unit combination from which a quantity is named in it [1]."""

Name = tuple[str, str | None]
"""Name and setting of a quantity; the setting is None where all settings share it."""


@dataclasses.dataclass(frozen=True)
class Combination:
    """A combination of quantities, and how well measurements tell it.

    Of quantities that must be positive it is a product of powers.
    """

    names: tuple[Name, ...]
    """Name and setting of each quantity."""
    powers: tuple[float, ...]
    """Their parts, or powers, of unit norm [1]."""
    sigma: float
    """Standard error by the noise alone, over what is plausible; may be infinite [1]."""
    share: float = np.inf
    """Share of the motion that it moves over all that is plausible of it [1]."""

    @property
    def is_told(self) -> bool:
        """Whether neither the rank nor the noise leaves it open."""
        return self.sigma < DETERMINED and self.share >= SHARE

    def has(self, index: int) -> bool:
        """Whether a quantity has a notable part in it.

        Args:
            index: Number of the quantity.

        Returns:
            Whether it has.
        """
        return bool(abs(self.powers[index]) >= NOTABLE_PART)

    def text(self) -> str:
        """The combination in words: which quantities rise and fall together."""
        parts = [
            (named(*name), self.powers[k]) for k, name in enumerate(self.names) if self.has(k)
        ]
        if len(parts) == 1:
            return f"{parts[0][0]} by itself"
        rising = [name for name, power in parts if power > 0]
        falling = [name for name, power in parts if power < 0]
        if not falling or not rising:
            return f"{_listed(rising + falling)} rising together"
        ending = "s" if len(falling) == 1 else ""
        return f"{_listed(rising)} rising while {_listed(falling)} fall{ending}"


def combinations(
    information: Float[np.ndarray, "k k"], names: tuple[Name, ...], *, motion: float = 0.0
) -> tuple[Combination, ...]:
    """The combinations that some information is about.

    Args:
        information: Scaled $J^T J$ over the noise's variance.
        names: Name and setting of each quantity.
        motion: Root of the sum of squares of all that was measured to move, over the noise;
            0 where that isn't known.

    Returns:
        From the best to the worst told.
    """
    values, vectors = np.linalg.eigh(information)
    # What rounding leaves of an eigenvalue that is zero.
    floor = len(values) * np.finfo(float).eps * max(float(values[-1]), 1e-300)
    found = []
    for number, vector in zip(values[::-1], vectors.T[::-1], strict=True):
        vector = vector * np.sign(vector[np.argmax(np.abs(vector))])
        size = float(np.sqrt(number)) if number > floor else 0.0
        found.append(
            Combination(
                names,
                tuple(float(power) for power in vector),
                sigma=1 / size if size else np.inf,
                share=float(size / motion) if motion > 0 else np.inf,
            )
        )
    return tuple(found)


def named(name: str, setting: str | None) -> str:
    """A quantity in words.

    Args:
        name: Its name.
        setting: Its setting, or None.

    Returns:
        "effective pretension at 350 N".
    """
    return name.replace("_", " ") + ("" if setting is None else f" at {setting}")


def _listed(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
