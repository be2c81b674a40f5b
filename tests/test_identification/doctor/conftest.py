"""Good campaigns of the loose rig, simulated once."""

import loose_rig
import pytest

from identification.campaign import Campaign


@pytest.fixture(scope="session")
def good() -> list[Campaign]:
    return [
        *loose_rig.campaigns([41, 42], elastic=False),
        *loose_rig.campaigns([43, 44], elastic=True),
    ]
