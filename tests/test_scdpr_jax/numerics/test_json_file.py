"""A JSON file is what it should be, or one error says where it isn't."""

import pytest

from scdpr_jax.numerics.json_file import JsonObject, read_json


class Gains(JsonObject):
    """What the file has to hold."""

    gain: float
    name: str = "PD"


def read(path):
    return read_json(path, Gains, expected="a gains.json", verb="tune")


def test_what_was_written_is_read(tmp_path):
    path = tmp_path / "gains.json"
    path.write_text('{"gain": 2.5}')
    assert read(path) == Gains(gain=2.5)


def test_a_missing_file_is_named_with_the_verb_that_writes_it(tmp_path):
    with pytest.raises(ValueError, match=r"gains\.json: can.t be read.*`scdpr tune`"):
        read(tmp_path / "gains.json")


@pytest.mark.parametrize(
    ("text", "where"),
    [
        ('{"gain": "much"}', "gain is wrong"),
        ('{"gain": "2.5"}', "gain is wrong"),
        ('{"gain": true}', "gain is wrong"),
        ('{"gain": NaN}', "gain is wrong"),
        ('{"gain": 1e999}', "gain is wrong"),
        ("{}", "gain is missing"),
        ("[", "the file is cut"),
    ],
)
def test_what_is_wrong_is_told_with_its_place(tmp_path, text, where):
    path = tmp_path / "gains.json"
    path.write_text(text)
    with pytest.raises(ValueError, match=where):
        read(path)
