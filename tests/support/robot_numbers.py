"""A robot of `scdpr_jax` as the event-by-event reference takes it."""

import dataclasses

from event_by_event import Numbers

from scdpr_jax.robot.quantities import value


def numbers_of(robot):
    frictions = {
        "lower_friction": robot.lower_carriage.friction.coefficient,
        "upper_friction": robot.upper_carriage.friction.coefficient,
        "static_surplus": robot.lower_carriage.friction.static_surplus,
        "knock_arm": robot.end_effector.knock_arm,
    }
    scalars = {
        field.name: float(
            frictions[field.name] if field.name in frictions else value(robot, field.name)
        )
        for field in dataclasses.fields(Numbers)
        if field.name != "drive_frictions"
    }
    return Numbers(**scalars, drive_frictions=tuple(map(float, robot.drive.frictions)))
