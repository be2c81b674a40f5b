"""What is left between a logged leg and a robot that is led along it, in residuals.

What is left between a model and a rig isn't noise: it lasts over many frames. So frames are
discounted, or three legs would overrule a campaign.
"""

import numpy as np
from jaxtyping import Float

from tuning.refinement.logged_leg import STEP
from tuning.refinement.replay import Replay, Replayed

DISCOUNT = 16.0
"""Frames of a camera that tell as much as one would if the model were right [1]."""
AFTERWARDS = 2.0
"""Weight of frames after the drives hold, over others: it is what matters [1]."""
INTERVAL, MISSING = 10, 0.5
"""Steps over which commands are averaged, and what their mean misses the model by [V]."""
MOVING = 30e-3
"""Velocity of the lower carriage from which commands tell of gain and friction [m/s]: slower,
backlash and ripple do."""


def residuals(
    replay: Replay, made: Replayed
) -> tuple[Float[np.ndarray, " m"], Float[np.ndarray, "m n"]]:
    """Residuals of a leg and their derivatives by corrections and start."""
    away, aside = seen(replay, made)
    after = replay.leg.seen_time > _held_from(replay)
    weight = np.where(after, AFTERWARDS, 1.0)[:, None] / np.sqrt(DISCOUNT)
    told, around = _told(replay, made)
    there = np.isfinite(away)
    return (
        np.concatenate([(weight * away)[there], told.ravel()]),
        np.concatenate(
            [(weight[..., None] * aside)[there], around.reshape(-1, around.shape[-1])]
        ),
    )


def seen(
    replay: Replay, made: Replayed
) -> tuple[Float[np.ndarray, "frames 3"], Float[np.ndarray, "frames 3 n"]]:
    """How far the camera is from a robot, over its noise; NaN where it saw nothing."""
    leg = replay.leg
    place, turn = leg.noise
    noise = np.array([place, turn, place])
    at = (leg.seen_time - leg.begins[0]) / STEP
    row = np.clip(at.astype(int), 0, leg.steps - 2)
    share = (at - row)[:, None]

    def between(own: np.ndarray) -> np.ndarray:
        part = share.reshape(-1, *(1,) * (own.ndim - 1))
        return own[row] * (1 - part) + own[row + 1] * part

    inside = ((at >= 0) & (at <= leg.steps - 1))[:, None]
    away = np.where(inside, (between(made.position) - leg.seen) / noise, np.nan)
    return away, between(made.slopes[0]) / noise[:, None]


def _told(
    replay: Replay, made: Replayed
) -> tuple[Float[np.ndarray, "intervals 2"], Float[np.ndarray, "intervals 2 n"]]:
    """How far what the drives were told is from what a robot takes, where it moves."""
    moving = (np.abs(replay.way.velocity[0, :, 0]) > MOVING).astype(float)

    def mean(own: np.ndarray) -> np.ndarray:
        whole = len(own) // INTERVAL * INTERVAL
        masked = own[:whole] * moving[:whole].reshape(-1, *(1,) * (own.ndim - 1))
        return masked.reshape(-1, INTERVAL, *own.shape[1:]).mean(axis=1) / MISSING

    return mean(made.voltage - replay.leg.commanded), mean(made.slopes[1])


def _held_from(replay: Replay) -> float:
    """When the drives hold for good [s]."""
    moving = np.flatnonzero(np.any(replay.way.velocity[0] != 0, axis=1))
    last = moving[-1] + 1 if moving.size else 0
    return float(replay.leg.begins[min(last, replay.leg.steps - 1)])
