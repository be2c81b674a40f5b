import pytest

from experiments.coordinates import plain_symbol
from scdpr_jax.parameters import QUANTITIES, REFINEMENTS


@pytest.mark.parametrize("known", [*QUANTITIES, *REFINEMENTS], ids=lambda known: known.name)
def test_every_symbol_of_a_quantity_reads_without_tex(known):
    assert "\\" not in "".join(plain_symbol(known.symbol))
