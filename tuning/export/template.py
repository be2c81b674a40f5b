"""The exported programs' fixed text, into which a tuning's numbers are filled."""

import importlib.resources
import string


def fill_in(name: str, **parts: str) -> str:
    """A template of `tuning/export/templates` with its parts.

    Args:
        name: The template's file name.
        **parts: Text for each `$part`.

    Returns:
        The whole text.

    Raises:
        KeyError: If a part is missing.
    """
    place = importlib.resources.files("tuning.export") / "templates" / name
    return string.Template(place.read_text(encoding="utf-8")).substitute(parts)
