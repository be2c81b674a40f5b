import math
import subprocess
import sys

import hypothesis
import hypothesis.strategies as st
import pytest

from identification.campaign import quantities
from identification.campaign.quantities import QuantityError, format_quantity, parse_quantity


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("35.1507 N/V", "N/V", 35.1507),
        ("2.5 kg m^2", "kg m^2", 2.5),
        ("2.5 kg·m²", "kg m^2", 2.5),
        ("2.5 kg*m**2", "kg m^2", 2.5),
        ("0.2 N m s", "N m s", 0.2),
        ("0.2 N·m·s", "N m s", 0.2),
        ("0.2 N m s/rad", "N m s", 0.2),
        ("482 mN m/V", "N m/V", 0.482),
        ("0.6352 V/rad", "V/rad", 0.6352),
        ("0.1 mrad", "rad", 1e-4),
        ("180 deg", "rad", math.pi),
        ("180 °", "rad", math.pi),
        ("0.5 rev", "rad", math.pi),
        ("26 mm", "m", 0.026),  # 26 * 1e-3 is a neighbour of this double
        ("26mm", "m", 0.026),
        ("-3 ms", "s", -0.003),
        ("0.35 kN", "N", 350.0),
        ("1e3 N", "N", 1000.0),
        ("2 1/s", "Hz", 2.0),
        ("2 s⁻¹", "Hz", 2.0),
        ("0.018", "1", 0.018),
        ("0.018 1", "1", 0.018),
        ("1.8 %", "1", 0.018),
        ("0 mm", "m", 0.0),
        ("1e-99999 mm", "m", 0.0),
    ],
)
def test_a_quantity_is_read_to_the_nearest_double_in_si(text, unit, value):
    assert parse_quantity(text, unit=unit) == value


@pytest.mark.parametrize(
    ("text", "unit", "problem"),
    [
        ("350", "N", "a number without its unit"),
        ("3", "rad", "a number without its unit"),
        ("350 m", "N", "'m' is no unit of the right dimension"),
        ("0 m", "N", "'m' is no unit of the right dimension"),
        ("5 1", "N", "'1' is no unit of the right dimension"),
        ("3 KG", "kg", "'KG' is no unit of the right dimension"),
        ("3 MM", "m", "'MM' is no unit of the right dimension"),
        ("3 mS", "s", "'mS' is no unit of the right dimension"),
        ("3 Nm", "N m", "'Nm' is no unit of the right dimension"),
        ("2 Hz", "rad/s", "'Hz' is no unit of the right dimension"),
        ("2 rad/s", "Hz", "'rad/s' is no unit of the right dimension"),
        ("3 rad", "1", "'rad' is no unit of the right dimension"),
        ("3 %", "rad", "'%' is no unit of the right dimension"),
        ("3 dB", "1", "'dB' is no unit of the right dimension"),
        ("3 dBm", "W", "'dBm' is no unit of the right dimension"),
        ("20 degC", "K", "'degC' is no unit of the right dimension"),
        ("20 degC", "N", "'degC' is no unit of the right dimension"),
        ("3 m + 2 m", "m", "'m + 2 m' is no unit"),
        ("3 m(", "m", "'m(' is no unit"),
        ("3 m/0", "m", "'m/0' is no unit"),
        ("3 m^99", "m", "'m^99' is no unit"),
        ("3 a_b", "m", "'a_b' is no unit"),
        ("nan N", "N", "not finite"),
        ("-inf N", "N", "not finite"),
        ("1e999 N", "N", "not finite"),
        ("1e307 km", "m", "not finite"),
        ("1,5 N", "N", "not a quantity"),
        ("1.2.3 N", "N", "not a quantity"),
        ("1_000 N", "N", "'_000 N' is no unit"),
        ("N", "N", "not a quantity"),
        ("", "1", "not a quantity"),
        ("__import__('os')", "1", "not a quantity"),
    ],
)
def test_what_is_no_such_quantity_is_refused_in_five_parts(text, unit, problem):
    with pytest.raises(QuantityError) as caught:
        parse_quantity(text, unit=unit, name="--gain")
    message = str(caught.value)
    assert message.startswith(f"`--gain`: {problem}, got {text!r}, expected a number")
    assert f"[{unit}]" in message
    assert message.partition("Write it like")[2]


def test_a_bare_number_is_handed_back_with_its_unit():
    with pytest.raises(ValueError, match='Write it like "350 N"'):
        parse_quantity("350", unit="N")


# What is larger is nothing of a rig, and refused.
finite = st.floats(-1e30, 1e30)


@hypothesis.given(value=finite, unit=st.sampled_from(["1", "N", "kg m^2", "N m s", "rad"]))
def test_a_written_quantity_is_read_back_exactly(value, unit):
    assert parse_quantity(format_quantity(value, unit), unit=unit) == value


@pytest.mark.parametrize("text", ["1e31 N", "-1e300 N", "1e8 YN"])
def test_a_number_that_nothing_of_a_rig_has_is_refused(text):
    with pytest.raises(ValueError, match="nothing of a rig has"):
        parse_quantity(text, unit="N")


@pytest.mark.parametrize(
    "text", ["1 " + "a" * 100_000, "1 N" + " N" * 1000, "9" * 100_000 + ",", "1 " + "N " * 7]
)
def test_a_quantity_longer_than_people_write_is_refused_at_once(text):
    with pytest.raises(QuantityError) as caught:
        parse_quantity(text, unit="N")
    assert len(str(caught.value)) < 400


def outcome(text, unit):
    try:
        return parse_quantity(text, unit=unit)
    except QuantityError as error:
        return error


def is_finite_or_explained(result):
    if isinstance(result, QuantityError):
        return result.remedy in str(result)
    return math.isfinite(result)


@hypothesis.given(text=st.text(), unit=st.sampled_from(["1", "N", "rad/s"]))
def test_any_text_is_a_finite_number_or_a_quantity_error(text, unit):
    assert is_finite_or_explained(outcome(text, unit))


@hypothesis.given(unit=st.text("mskgNVradHz%°µ/*^²·() 0123456789+-.[]", max_size=12))
def test_any_text_for_a_unit_is_a_finite_number_or_a_quantity_error(unit):
    assert is_finite_or_explained(outcome(f"1.5 {unit}", "m"))


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [(350.0, "N", "350 N"), (0.018, "1", "0.018"), (1e-7, "kg m^2", "1e-07 kg m^2")],
)
def test_a_quantity_is_written_in_the_shortest_way(value, unit, text):
    assert format_quantity(value, unit) == text


def test_a_quantity_to_be_written_is_finite():
    with pytest.raises(ValueError, match=r"finite \[N\], got nan"):
        format_quantity(math.nan, "N")


def test_importing_the_module_does_not_load_pint():
    code = "import sys, identification.campaign.quantities; assert 'pint' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize(("written", "unit"), list(quantities.EVERYDAY))
def test_everyday_units_are_as_pint_has_them(written, unit):
    known = quantities.EVERYDAY[written, unit]
    assert quantities._pint_conversion(written, unit) == known
