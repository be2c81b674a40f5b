"""What a user sees of `tuning` first."""

import pkgutil
import types

import pytest

import tuning

WANTED = (
    "tune",
    "plan_leg",
    "co_design",
    "recommend",
    "read_tuning",
    "write_tuning",
    "read_plan",
    "write_plan",
    "read_law",
    "write_codesign",
    "control_objects",
    "write_exports",
    "design_for_spectrum",
    "Tuning",
    "Plan",
    "CoDesign",
    "CATALOGUE",
)


@pytest.mark.parametrize("name", WANTED)
def test_what_a_user_calls_is_at_the_front_door(name):
    assert name in dir(tuning)


def test_no_wing_stands_at_the_front_door():
    wings = {module.name for module in pkgutil.iter_modules(tuning.__path__)}
    assert not wings & set(dir(tuning))
    shown = (getattr(tuning, name) for name in dir(tuning))
    assert not any(isinstance(thing, types.ModuleType) for thing in shown)
