"""The planar cable robot with a single cable loop: a differentiable model.

What a user calls is here, and `dir(scdpr_jax)` shows it. The adaptive solvers are the
exception, as they take a second to import: `scdpr_jax.engines.adaptive`.
"""

from scdpr_jax.front_door import front_door as _front_door

__getattr__, __dir__ = _front_door(
    __name__,
    {
        "scdpr_jax.command.controller": (
            "PD",
            "Controller",
            "published_pd",
        ),
        "scdpr_jax.command.sensors": (
            "Camera",
            "Encoder",
        ),
        "scdpr_jax.command.shaper": (
            "ShapedTrajectory",
            "Shaper",
            "residual_vibration",
        ),
        "scdpr_jax.command.trajectory": (
            "BezierLeg",
            "Manoeuvre",
            "Trajectory",
            "rest_to_rest",
            "table_3",
        ),
        "scdpr_jax.engines.closed_loop": (
            "ClosedLoop",
            "closed_loop",
        ),
        "scdpr_jax.engines.linear_stepping": ("simulate_linear",),
        "scdpr_jax.engines.stepping": (
            "Inputs",
            "interpolate",
            "simulate",
            "step",
        ),
        "scdpr_jax.linear.model": (
            "StateSpace",
            "linearise",
            "mass_matrix",
            "stiffness",
            "stiffness_matrix",
        ),
        "scdpr_jax.linear.modes": (
            "BOTH_HELD",
            "DRIVEN",
            "LOWER_HELD",
            "PRINTED",
            "Condition",
            "Modes",
            "held_frequency",
            "modes",
            "natural_frequencies",
        ),
        "scdpr_jax.linear.stiffness": ("horizontal_stiffness",),
        "scdpr_jax.numerics.batches": ("in_chunks",),
        "scdpr_jax.robot.cable": (
            "cable_angles",
            "loop_forces",
            "potential",
        ),
        "scdpr_jax.robot.dynamics": (
            "accelerations",
            "energy",
        ),
        "scdpr_jax.robot.friction": (
            "Coulomb",
            "Friction",
            "SmoothCoulomb",
        ),
        "scdpr_jax.robot.kinematics": (
            "forward_kinematics",
            "inverse_kinematics",
        ),
        "scdpr_jax.robot.parameters": (
            "Cable",
            "Carriage",
            "Drive",
            "EndEffector",
            "Frame",
            "Robot",
            "exact",
            "smoothed",
            "with_friction",
        ),
        "scdpr_jax.robot.prototype": (
            "PROVENANCE",
            "consistent",
            "published",
        ),
        "scdpr_jax.robot.quantities": (
            "QUANTITIES",
            "Quantity",
            "replace",
            "value",
        ),
        "scdpr_jax.robot.state": (
            "State",
            "carriages",
            "driven",
            "pose",
            "rest",
        ),
        "scdpr_jax.statics.workspace": ("static_workspace",),
    },
)
