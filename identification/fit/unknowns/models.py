"""The models of a robot that are compared: the usual one and what may refine it."""

import dataclasses


@dataclasses.dataclass(frozen=True)
class Refinement:
    """Something that the usual model leaves out of a real robot."""

    lacks: str
    """What it is, for a verdict: "the usual model lacks …"."""
    free: tuple[str, ...]
    """Names of the quantities that it frees."""


REFINEMENTS: tuple[Refinement, ...] = (
    Refinement("drives with dry friction of their own each", ("drive_friction_difference",)),
    Refinement("a tension that rises as the loop's path gets longer", ("loop_stiffness",)),
    Refinement(
        "the true places at which the cables are attached to the end-effector",
        ("lower_offset", "upper_offset"),
    ),
    Refinement("a friction of its own for each carriage", ("upper_friction_coefficient",)),
    Refinement(
        "viscous damping of the carriages",
        ("lower_carriage_damping", "upper_carriage_damping"),
    ),
    Refinement(
        "a friction of the carriages that is higher near standstill",
        ("static_friction_surplus", "stribeck_velocity"),
    ),
)
"""What may be added to the usual model, each together with those that were added before."""


@dataclasses.dataclass(frozen=True)
class Model:
    """One of the models that were compared."""

    added: tuple[str, ...]
    """What it has beyond the usual model, in the order in which it was added."""
    free: tuple[str, ...]
    """Names of the quantities that it frees."""
    misfit: float
    """Misfit per measurement of the fitted runs [1]."""
    aic: float
    """Akaike's criterion: the misfit plus twice the number of unknowns [1]."""
    bic: float
    """Schwarz's criterion: the misfit plus as many times the measurements' logarithm [1]."""
    held_out: float | None
    """Misfit of the runs that were held out, None without any [1]."""
    path_error: float | None
    """Root mean square distance of their end-effector from its prediction [m]."""
