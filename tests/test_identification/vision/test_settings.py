import numpy as np
import pytest
from rig_film import document, usual

from identification.vision.settings import VisionError, read_vision


@pytest.fixture
def text():
    return document(usual(1), np.random.default_rng(1), boards=True, stamped=False)


def swap(old, new):
    return lambda text: text.replace(old, new, 1)


def refusal(tmp_path, text):
    path = tmp_path / "vision.toml"
    path.write_text(text)
    with pytest.raises(VisionError) as caught:
        read_vision(path)
    return str(caught.value)


def test_what_is_written_is_read_in_si_units(tmp_path, text):
    (tmp_path / "vision.toml").write_text(text)
    vision = read_vision(tmp_path / "vision.toml")
    assert vision.time.exposure == 4e-3
    assert vision.marks[0].x == -0.045
    assert [marker.body for marker in vision.markers].count("end_effector") == 2
    assert vision.colours["red"].hue[0] > vision.colours["red"].hue[1]


def test_a_colour_can_be_a_word_alone(tmp_path, text):
    head, _, rest = text.partition("[colours.yellow]")
    _, _, after = rest.partition("[colours.green]")
    (tmp_path / "vision.toml").write_text(
        head + '[colours]\nyellow = "yellow"\n[colours.green]' + after
    )
    assert "yellow" in read_vision(tmp_path / "vision.toml").colours


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (swap('exposure = "4 ms"', "exposure = 4"), ("row 7, key 'time.exposure'", "[s]")),
        (swap("hue = ", "hu = "), ("colours.yellow.hue", "'hu'")),
        (swap('diameter = "44 mm"', 'diameter = "44 s"'), ("marks 1.diameter", "'44 s'")),
        (swap('direction = "down"', 'direction = "left"'), ("'down' or 'up'", "'left'")),
        (swap('colour = "green"', 'colour = "gren"'), ("markers 1.colour", "'gren'", "green")),
        (swap('body = "lower_carriage"', 'body = "lower"'), ("markers 3.body", "'lower'")),
        (swap('square = "40 mm"', ""), ("calibration", "no lens", "photos")),
        (swap('frame_rate = "30 Hz"', ""), ("no clock", "stamps")),
        (swap('x = "110 mm"', 'x = "-110 mm"'), ("two markers at one place", "markers 2")),
        (swap('exposure = "4 ms"', 'exposure = ""'), ("empty", "Fill in time.exposure")),
        (swap("format = 1", "format = 2"), ("format = 1", "row 1")),
        (swap("[time]", "[time"), ("not valid TOML",)),
        (swap("[time]", "[tim]"), ("key 'time': a missing key", '"time"')),
        (swap("near = [", "neer = ["), ("'neer'", "near")),
    ],
)
def test_what_cannot_be_is_refused_with_its_place_and_a_remedy(tmp_path, text, change, words):
    changed = change(text)
    assert changed != text
    message = refusal(tmp_path, changed)
    for word in words:
        assert word in message


def test_three_marks_are_too_few(tmp_path, text):
    parts = text.split("[[marks]]")
    last, _, markers = parts[-1].partition("[[markers]]")
    short = "[[marks]]".join(parts[:4]) + "[[markers]]" + markers
    assert "too few marks, got 3, expected at least 4" in refusal(tmp_path, short)
    assert last


def test_one_marker_on_the_end_effector_is_too_few(tmp_path, text):
    parts = text.split("[[markers]]")
    message = refusal(tmp_path, "[[markers]]".join([parts[0], *parts[2:]]))
    assert "one marker can't tell how the end-effector is turned" in message


def test_a_file_that_is_not_there_is_one_message(tmp_path):
    with pytest.raises(VisionError, match="the file is missing"):
        read_vision(tmp_path / "nothing.toml")
