import pytest

from experiments.page.coordinates import plain_symbol
from scdpr_jax.robot.quantities import QUANTITIES, REFINEMENTS


@pytest.mark.parametrize("known", [*QUANTITIES, *REFINEMENTS], ids=lambda known: known.name)
def test_every_symbol_of_a_quantity_reads_without_tex(known):
    assert "\\" not in "".join(plain_symbol(known.symbol))
