"""The lines that a firmware is told of a shaper."""

from tuning.export.firmware import IMPULSES, pasted
from tuning.shapers.catalogue import CATALOGUE
from tuning.shapers.comparison import Fitted

FITS = [Fitted(entry, 45.25, entry.design(45.25, 0.1), 0.02) for entry in CATALOGUE]


def test_each_firmware_is_told_of_a_shaper_that_it_makes():
    made = {each.firmware: each for each in pasted(FITS, axis="y", damping_ratio=0.1)}
    assert made["Marlin"].lines == ("M593 Y F45.25 D0.1",)
    section, kind, frequency, ratio = made["Klipper"].lines
    assert section == "[input_shaper]"
    assert kind == f"shaper_type_y: {made['Klipper'].fit.entry.name}"
    assert frequency == "shaper_freq_y: 45.2"
    assert ratio == "damping_ratio_y: 0.1"


def test_no_shaper_has_more_impulses_than_its_firmware_makes():
    for each in pasted(FITS, axis="x", damping_ratio=0.1):
        assert each.fit.shaper.times.size <= IMPULSES[each.firmware.lower()]


def test_what_a_firmware_does_not_know_has_no_lines():
    unknown = [fit for fit in FITS if fit.entry.name == "zvdd"]
    assert pasted(unknown, axis="x", damping_ratio=0.1) == ()
