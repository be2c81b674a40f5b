import pkgutil
import types

import identification


def test_the_front_door_shows_calls_and_types_and_no_wing():
    wings = {wing.name for wing in pkgutil.iter_modules(identification.__path__)}
    assert len(wings) > 5
    assert not wings.intersection(dir(identification))
    shown = [getattr(identification, name) for name in dir(identification)]
    assert all(callable(thing) for thing in shown)
    assert not any(isinstance(thing, types.ModuleType) for thing in shown)


def test_what_a_user_calls_is_there():
    calls = {
        "estimate",
        "estimate_many",
        "frequency_map",
        "posterior",
        "profile",
        "propose",
        "read_campaign",
        "read_parameters",
        "select",
        "write_parameters",
    }
    assert calls <= set(dir(identification))
