"""CI's share of many cases."""

import pytest


def share(cases, count):
    """The first cases, and the others marked `slow`."""
    return [
        pytest.param(case, marks=[pytest.mark.slow] if place >= count else [])
        for place, case in enumerate(cases)
    ]
