"""A package's front door: what a user calls, brought in when it is called.

Importing a package is then as cheap as what is used of it: logs are read and checked without
JAX, whose import takes longer than that.
"""

import importlib
import sys
from collections.abc import Callable, Mapping
from typing import Any


def front_door(
    package: str, contents: Mapping[str, tuple[str, ...]]
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """The `__getattr__` and `__dir__` of a package that shows what is in its modules.

    Args:
        package: Name of the package.
        contents: What it shows, by the module in which it stands.

    Returns:
        Both functions, to be bound in the package's `__init__`.
    """
    places = {name: module for module, names in contents.items() for name in names}

    def bring(name: str) -> Any:
        if name not in places:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value = getattr(importlib.import_module(places[name]), name)
        setattr(sys.modules[package], name, value)
        return value

    def shown() -> list[str]:
        return sorted(places)

    return bring, shown
