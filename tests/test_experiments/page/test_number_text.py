import math

import hypothesis
import hypothesis.strategies as st
import pytest

from experiments.page.number_text import (
    capitalised,
    percent,
    plain,
    rounded,
    short,
    split_at_point,
)

positive = st.floats(1e-9, 1e6)


@hypothesis.given(value=st.floats(-1e6, 1e6), sigma=positive)
def test_a_value_is_printed_to_a_tenth_of_its_error_at_least(value, sigma):
    printed = float(rounded(value, sigma).replace("−", "-"))
    # Two significant digits of the error: half a unit of the second is 5 % of it at most;
    # the printed value itself rounds in double precision.
    assert abs(printed - value) <= 0.05 * sigma + 1e-15 * abs(value) + 0.5e-12


@hypothesis.given(value=positive, digits=st.integers(1, 6))
def test_a_plain_number_has_no_exponent_and_its_digits(value, digits):
    text = plain(value, digits)
    assert "e" not in text
    # Half a unit of the last digit; twelve decimals at most.
    assert abs(float(text) - value) <= 0.5 * 10 ** (1 - digits) * value * 1.001 + 0.5e-12


@pytest.mark.parametrize("sigma", [0.0, math.inf])
def test_a_value_without_error_keeps_its_own_digits(sigma):
    assert rounded(0.1405, sigma) == "0.1405"


def test_what_is_not_finite_is_printed_as_such():
    assert (rounded(math.inf, 1.0), short(-math.inf), plain(math.nan)) == ("∞", "−∞", "–")


def test_a_minus_is_a_minus():
    assert rounded(-1.5, 0.1) == "−1.50"
    assert percent(-0.0125) == "−1.2 %"


def test_both_parts_of_a_number_make_it_up():
    assert split_at_point("85.170") == ("85", ".170")
    assert split_at_point("10") == ("10", "")


def test_a_sentence_begins_with_a_capital_and_keeps_its_names():
    assert capitalised("horizontal PD run") == "Horizontal PD run"
    assert capitalised("") == ""


def test_what_is_rounding_is_printed_as_zero():
    assert percent(3e-17) == "0 %"
    assert plain(-5e-13) == "0"
