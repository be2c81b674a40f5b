# ruff: noqa: E501  (one fault a line: the table is read by its columns)
import os

import good_campaign
import hypothesis
import hypothesis.strategies as st
import pytest

from identification.campaign.check import check_campaign
from identification.campaign.faults import CampaignError, Fault, listed
from identification.campaign.read import read_campaign

RIG = "campaign.toml"
RUN = "0001-step/run.toml"
KNOCK = "0002-knock/run.toml"
DRIVE = "0001-step/drive.csv"
CAMERA = "0001-step/camera.csv"
HEADER = good_campaign.DRIVE.splitlines()[0]


@pytest.fixture
def folder(tmp_path):
    return good_campaign.write(tmp_path / "small")


def faults_of(folder):
    with pytest.raises(CampaignError) as caught:
        read_campaign(folder)
    assert check_campaign(folder).faults == caught.value.faults
    assert all(str(fault) in str(caught.value) for fault in caught.value.faults)
    return caught.value.faults


def swap(old, new):
    def change(text):
        assert old in text
        return text.replace(old, new, 1)

    return change


def append(header):
    """One more column."""

    def change(text):
        first, *rows = text.splitlines()
        return "\n".join([f"{first},{header}", *(f"{row},7" for row in rows)])

    return change


def only(text):
    return lambda _: text


def cell(new):
    """Another voltage_1 in the row at 2 ms, the fourth of the file."""
    return swap("2,1500,", f"2,{new},")


TEXT_FAULTS = [
    # What is spoilt, how; the place, the problem, what was found, what is expected, remedy.
    # Texts that should be numbers, and rows.
    (DRIVE, cell("abc"), "row 4, column 'voltage_1 [mV]'", "not a number", "'abc'", "finite decimal", "Correct the cell"),
    (DRIVE, cell("1_000"), "row 4, column 'voltage_1 [mV]'", "not a number", "'1_000'", "finite decimal", "Correct the cell"),
    (DRIVE, cell("١"), "row 4, column 'voltage_1 [mV]'", "not a number", "'١'", "finite decimal", "Correct the cell"),
    (DRIVE, cell("0x10"), "row 4, column 'voltage_1 [mV]'", "not a number", "'0x10'", "finite decimal", "Correct the cell"),
    (DRIVE, cell(""), "row 4, column 'voltage_1 [mV]'", "an empty cell", "''", "finite decimal", "delete the row"),
    (DRIVE, cell("NaN"), "row 4, column 'voltage_1 [mV]'", "not a finite number", "'NaN'", "finite decimal", "delete the row"),
    (DRIVE, cell("-inf"), "row 4, column 'voltage_1 [mV]'", "not a finite number", "'-inf'", "finite decimal", "delete the row"),
    (DRIVE, cell("1e999"), "row 4, column 'voltage_1 [mV]'", "not a finite number", "'1e999'", "finite decimal", "delete the row"),
    (DRIVE, cell("1e9999999"), "row 4, column 'voltage_1 [mV]'", "not a finite number", "'1e9999999'", "finite decimal", "Correct the cell"),
    (DRIVE, cell("1500,7"), "row 4", "a row of another length", "8 cells", "7 cells", "decimals with a point"),
    (DRIVE, swap("3,1500,-1.5,500,-360,14,0.5", "3,1500,-1.5"), "row 5", "a row of another length", "3 cells", "7 cells", "cut off"),
    (DRIVE, swap("\n2,", "\n\n2,"), "row 4", "a row of another length", "0 cells", "7 cells", "delete the row"),
    (DRIVE, swap("\n2,", "\n1.0,"), "row 4, column 't [ms]'", "time doesn't increase", "1.0 after 1", "a later time", "Delete repeated rows"),
    (DRIVE, swap("\n3,", "\n0.5,"), "row 5, column 't [ms]'", "time doesn't increase", "0.5 after 2", "a later time", "clock was set back"),
    (DRIVE, swap('2,1500,', '2,"1500,'), "row 5", "a row of another length", "2 cells", "7 cells", "delete the row"),
    (DRIVE, cell("1" * 200_000), "row 4", "can't be split", "field limit", "separated by commas", "quotation mark"),
    (CAMERA, swap("2000,27", "2000,NaN"), "row 3, column 'x_e [mm]'", "not a finite number", "'NaN'", "finite decimal", "Leave the cell empty"),
    (CAMERA, swap("2000,27", ",27"), "row 3, column 't [us]'", "an empty cell", "''", "finite decimal", "delete the row"),
    # Headers.
    (DRIVE, swap("voltage_1 [mV]", "voltage_1"), "row 1, column 'voltage_1'", "a column without a unit", "'voltage_1'", "[V], [mV]", 'Write "voltage_1 [V]"'),
    (DRIVE, swap("voltage_1 [mV]", "voltage_1 (mV)"), "row 1, column 'voltage_1 (mV)'", "a column without a unit", "'voltage_1 (mV)'", "[V], [mV]", 'Write "voltage_1 [V]"'),
    (DRIVE, append("comment"), "row 1, column 'comment'", "a column without a unit", "'comment'", "square brackets", 'Write "comment [unit]"'),
    (DRIVE, append(""), "row 1", "a column without a unit", "''", "square brackets", "Name column 8"),
    (DRIVE, swap("voltage_1 [mV]", "voltage_1 [kV]"), "row 1, column 'voltage_1 [kV]'", "a unit that this column can't have", "[kV]", "one of [V], [mV]", "Convert the column"),
    (DRIVE, swap("voltage_1 [mV]", "voltage_1 [v]"), "row 1, column 'voltage_1 [v]'", "a unit that this column can't have", "[v]", "one of [V], [mV]", "Convert the column"),
    (DRIVE, swap("t [ms]", "t [min]"), "row 1, column 't [min]'", "a unit that this column can't have", "[min]", "one of [s], [ms], [us]", "Convert the column"),
    (CAMERA, swap("delta_e [deg]", "delta_e [mm]"), "row 1, column 'delta_e [mm]'", "a unit that this column can't have", "[mm]", "one of [rad], [deg]", "Convert the column"),
    (DRIVE, append("voltage_1 [V]"), "row 1, column 'voltage_1 [V]'", "a column that is there twice", "a second 'voltage_1'", "once", "Rename or delete"),
    (DRIVE, swap("voltage_2 [V]", "voltage2 [V]"), "row 1", "column 'voltage_2' is missing", "voltage2 [V]", "one of [V], [mV]", 'Is it "voltage2"'),
    (DRIVE, swap("alpha_1 [count]", "noise [1]"), "row 1", "column 'alpha_1' is missing", "noise [1]", "[count]", 'header "alpha_1 [rad]"'),
    (DRIVE, swap("current_1 [mA]", "noise [1]"), "row 1", "column 'current_1' is missing", "noise [1]", "[A], [mA]", 'or delete "current_2"'),
    (DRIVE, swap("t [ms]", "T [ms]"), "row 1", "column 't' is missing", "T [ms]", "[s], [ms], [us]", '"t [s]"'),
    (CAMERA, swap("q_4 [m]", "q_5 [m]"), "row 1", "column 'q_4' is missing", "q_5 [m]", "[m], [cm], [mm]", 'Is it "q_5"'),
    # Whole files.
    (DRIVE, only(""), "row 1", "the file is empty", "nothing", "at least two samples", "Export the log again"),
    (DRIVE, only("\n \n"), "row 1", "the file is empty", "nothing", "at least two samples", "Export the log again"),
    (DRIVE, only(HEADER), "row 1", "too few samples", "a header only", "at least two samples", "Export the log again"),
    (DRIVE, only(HEADER + "\n0,0,0,0,0,0,0\n"), "row 2", "too few samples", "1 sample", "at least two samples", "Export the log again"),
    (CAMERA, only("\n".join(good_campaign.CAMERA.splitlines()[:2])), "row 2", "too few samples", "1 sample", "at least two samples", "delete camera.csv"),
    (DRIVE, swap(HEADER + "\n", ""), "row 1", "no header row", "'0,0,0.0,0,0,0,0'", "name and unit", "Put a header above"),
    (DRIVE, lambda text: text.replace(",", ";").replace(".", ","), "row 1", "separated by semicolons", "t [ms];voltage", "commas between columns", "Export the log again"),
    (DRIVE, lambda text: text.replace(",", "\t"), "row 1", "separated by tabulators", "t [ms]\\tvoltage", "commas between columns", "Export the log again"),
    (DRIVE, swap("\n2,", "\n2\0,"), "row 4", "not text in UTF-8", "a zero byte", "text file", "Save it as plain text"),
    (DRIVE, only("PK\x03\x04\0\0\n\0"), "row 1", "not text in UTF-8", "a zero byte", "text file", "Save it as plain text"),
    # campaign.toml.
    (RIG, swap("format = 1\n", ""), "key 'format'", "the format isn't stated", "no such key", "format = 1", "Write `format = 1`"),
    (RIG, swap("format = 1", "format = 2"), "row 1, key 'format'", "not a format that is known", "2", "format = 1", "version that wrote it"),
    (RIG, swap("format = 1", "format = true"), "row 1, key 'format'", "not a format that is known", "True", "format = 1", "version that wrote it"),
    (RIG, swap("format = 1", 'format = "1"'), "row 1, key 'format'", "not a format that is known", "'1'", "format = 1", "version that wrote it"),
    (RIG, swap("= 1000", "= "), "row 3", "not valid TOML", "Invalid value", "key = ", "Correct that line"),
    (RIG, only("format = 1\n[robot"), "row 2", "not valid TOML", "at end of document", "key = ", "Correct that line"),
    (RIG, only("format = " + "9" * 5000), "campaign.toml", "not valid TOML", "digits", "key = ", "Correct that line"),
    (RIG, only("format = " + "[" * 9999), "campaign.toml", "not valid TOML", "recursion", "key = ", "Correct that line"),
    (RIG, swap("effective_radius", "efective_radius"), "row 6, key 'robot.efective_radius'", "an unknown key", "'efective_radius'", "one of frame_width", 'nearest known key is "effective_radius"'),
    (RIG, swap("[robot]", "[robots]"), "row 5, key 'robots'", "an unknown key", "'robots'", "one of name, counts_per_rev", 'nearest known key is "robot"'),
    (RIG, swap("camera_angle_sigma", "effective_radius"), "row 10, key 'sensors.effective_radius'", "an unknown key", "'effective_radius'", "encoder_sigma", "below the heading [robot]"),
    (RIG, swap('"1 mrad"', '"1 mrad"\nname = "x"'), "row 11, key 'sensors.name'", "an unknown key", "'name'", "encoder_sigma", "above the first [table]"),
    (RIG, swap('"73 mm"', '"73"'), "row 6, key 'robot.effective_radius'", "a number without its unit", "'73'", "[m]", 'Write it like "73 m"'),
    (RIG, swap('"73 mm"', "73"), "row 6, key 'robot.effective_radius'", "not a text with a unit", "73", "[m] in quotation marks", 'Write it like "73 m"'),
    (RIG, swap('"73 mm"', "0x" + "f" * 4000), "row 6, key 'robot.effective_radius'", "not a text with a unit", "too long to print", "[m] in quotation marks", "Write it like"),
    (RIG, swap('"73 mm"', '"73 ms"'), "row 6, key 'robot.effective_radius'", "no unit of the right dimension", "'73 ms'", "[m]", 'Write it like "0.5 m"'),
    (RIG, swap('"73 mm"', '"nan m"'), "row 6, key 'robot.effective_radius'", "not finite", "'nan m'", "[m]", "Write it like"),
    (RIG, swap('"73 mm"', '"-73 mm"'), "row 6, key 'robot.effective_radius'", "not positive", "'-73 mm'", "above zero [m]", 'Write it like "0.073 m"'),
    (RIG, swap('"73 mm"', '"0 mm"'), "row 6, key 'robot.effective_radius'", "not positive", "'0 mm'", "above zero [m]", "Write it like"),
    (RIG, swap('"1.8 %"', '"-1.8 %"'), "row 7, key 'robot.friction_coefficient'", "negative", "'-1.8 %'", "zero or more [1]", 'Write it like "0.018"'),
    (RIG, swap('"1 mrad"', '"1 mm"'), "row 10, key 'sensors.camera_angle_sigma'", "no unit of the right dimension", "'1 mm'", "[rad]", "Write it like"),
    (RIG, swap('"1 mrad"', '"1 mrad"\n[sensors.runs.0001-stop]\nx_e = "1 mm"'), "row 11, key 'sensors.runs'", "a run that isn't there", "'0001-stop'", "a run's folder", 'The nearest is "0001-step"'),
    (RIG, swap('"1 mrad"', '"1 mrad"\n[sensors.runs.0001-step]\nx_e = "1 rad"'), "row 12, key 'sensors.runs.0001-step.x_e'", "no unit of the right dimension", "'1 rad'", "[m]", "Write it like"),
    (RIG, swap('"1 mrad"', '"1 mrad"\n[sensors.runs.0001-step]\nq_5 = "1 mm"'), "row 12, key 'sensors.runs.0001-step.q_5'", "an unknown key", "'q_5'", "one of x_e", "nearest known key"),
    (RIG, swap('"1 mrad"', '"1 mrad"\n[sensors.runs]\n0001-step = 3'), "row 12, key 'sensors.runs.0001-step'", "valid dictionary", "3", "[sensors.runs.0001-step]", "Write it like"),
    (RIG, swap("= 1000", "= 0"), "row 3, key 'counts_per_rev'", "greater than 0", "0", "26624", "Write it like"),
    (RIG, swap("= 1000", "= inf"), "row 3, key 'counts_per_rev'", "finite number", "inf", "26624", "Write it like"),
    (RIG, swap("= 1000", "= 0x" + "f" * 4000), "row 3, key 'counts_per_rev'", "number", "", "26624", "Write it like"),
    (RIG, swap("= 1000", '= "1000"'), "row 3, key 'counts_per_rev'", "valid number", "'1000'", "26624", "without quotation marks"),
    (RIG, swap('"small rig"', "3"), "row 2, key 'name'", "valid string", "3", "rig A", "Write it like"),
    (RIG, only("format = 1\nrobot = 3\ncounts_per_rev = 9"), "row 2, key 'robot'", "valid dictionary", "3", "heading [robot]", "Write it like"),
    # run.toml.
    (RUN, swap('"torque_step"', '"torque-step"'), "row 2, key 'kind'", "an unknown kind", "'torque-step'", "torque_step, breakaway, motor_step, pseudo_impulse, manoeuvre, free", 'Is it "torque_step"'),
    (RUN, swap('"torque_step"', '["free"]'), "row 2, key 'kind'", "an unknown kind", "['free']", "breakaway", "Is it"),
    (RUN, swap('"torque_step"', '"xyz"'), "row 2, key 'kind'", "an unknown kind", "'xyz'", "breakaway", '"free" takes'),
    (RUN, swap('kind = "torque_step"\n', ""), "key 'kind'", "a missing key", "no such key", "kind = ", 'Add a line like kind = "torque_step"'),
    (RUN, swap('pretension = "0.35 kN"\n', ""), "key 'pretension'", "a missing key", "no such key", '"350 N"', 'Add a line like pretension = "350 N"'),
    (RUN, swap('"0.35 kN"', '"-1 N"'), "row 3, key 'pretension'", "not positive", "'-1 N'", "above zero [N]", 'Write it like "1 N"'),
    (RUN, swap('y_e = "0.300 m"\n', ""), "row 6, key 'initial.y_e'", "a missing key", "no such key", "0.300 m", "Add a line like"),
    (RUN, swap('"2 ms"', '"unkown"'), "row 11, key 'camera.clock_offset'", "not a quantity", "'unkown'", "[s]", "Write it like"),
    (RUN, swap("[camera]", '[knock]\nstart = "0 s"\nduration = "1 ms"\n[camera]'), "row 10, key 'knock'", "a knock on a run that has none", 'kind = "torque_step"', "pseudo_impulse", "delete the table [knock]"),
    (RUN, swap("[initial]", "[start]"), "row 6, key 'start'", "an unknown key", "'start'", "initial", "nearest known key"),
    (KNOCK, swap('start = "1 ms"', 'start = "1 s"'), "row 6, key 'knock.start'", "the knock isn't within the run", "1 s", "0 s to 0.003 s", "clock of drive.csv"),
    (KNOCK, swap('duration = "1 ms"', 'duration = "0 ms"'), "row 7, key 'knock.duration'", "not positive", "'0 ms'", "above zero [s]", "Write it like"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("file", "change", "place", "problem", "got", "expected", "remedy"), TEXT_FAULTS
)
def test_a_fault_is_told_in_five_parts(
    folder, file, change, place, problem, got, expected, remedy
):
    path = folder / file
    path.write_text(change(path.read_text()), encoding="utf-8")
    (fault,) = faults_of(folder)
    assert fault.file == file
    assert place in fault.where
    assert problem in fault.what
    assert got in fault.got
    assert expected in fault.expected
    assert remedy in fault.remedy


@pytest.mark.parametrize(
    ("content", "row", "byte"),
    [
        (HEADER.encode() + b"\n0,0,0\xff,0,0,0,0\n", 2, "0xff"),
        (HEADER.encode("utf-16"), 1, "0xff"),
        (b"TDSm\n\x0e\n\x80\n", 3, "0x80"),
    ],
)
def test_bytes_that_are_no_utf8_are_located(folder, content, row, byte):
    (folder / DRIVE).write_bytes(content)
    (fault,) = faults_of(folder)
    assert (fault.what, fault.row) == ("not text in UTF-8", row)
    assert byte in fault.got
    assert "importers" in fault.remedy


@pytest.mark.parametrize("file", [RIG, RUN, DRIVE])
def test_a_missing_file_is_a_fault(folder, file):
    (folder / file).unlink()
    (fault,) = faults_of(folder)
    assert (fault.what, fault.file) == ("the file is missing", file)
    assert "Copy it there" in fault.remedy


def test_a_folder_in_a_files_place_is_a_fault(folder):
    (folder / DRIVE).unlink()
    (folder / DRIVE).mkdir()
    (fault,) = faults_of(folder)
    assert (fault.what, fault.file) == ("the file can't be read", DRIVE)


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="root may read anything")
def test_a_file_without_permission_is_a_fault(folder):
    (folder / DRIVE).chmod(0)
    (fault,) = faults_of(folder)
    assert fault.what == "the file can't be read"


def test_counts_need_the_counts_of_a_turn(folder):
    path = folder / RIG
    path.write_text(path.read_text().replace("counts_per_rev = 1000\n", ""))
    first, second = faults_of(folder)
    assert (first.file, second.file) == (DRIVE, "0002-knock/drive.csv")
    assert first.where == f"{DRIVE}, row 1, column 'alpha_1 [count]'"
    assert "`counts_per_rev` in campaign.toml" in first.remedy


def test_a_folder_that_is_not_there_is_a_fault(tmp_path):
    (fault,) = faults_of(tmp_path / "none")
    assert (fault.what, fault.got) == ("the campaign doesn't exist", "no such folder")


def test_a_file_is_no_campaign(folder):
    (fault,) = faults_of(folder / RIG)
    assert (fault.what, fault.got) == ("the campaign isn't a folder", "a file")


def test_a_campaign_needs_a_run(tmp_path):
    (tmp_path / RIG).write_text("format = 1")
    (fault,) = faults_of(tmp_path)
    assert fault.what == "the campaign has no run"
    assert "Copy the runs there" in fault.remedy


def test_faults_of_several_files_are_listed_together(folder):
    for file, change in [
        (RIG, swap('"73 mm"', '"73"')),
        (RUN, swap("notes", "note")),
        (DRIVE, swap("voltage_2 [V]", "voltage_2 [kV]")),
        (CAMERA, swap("2000,27", "2000,x")),
    ]:
        path = folder / file
        path.write_text(change(path.read_text()))
    faults = faults_of(folder)
    assert [fault.file for fault in faults] == [RIG, RUN, DRIVE, CAMERA]


def test_a_header_and_a_cell_of_one_file_are_listed_together(folder):
    path = folder / DRIVE
    path.write_text(cell("x")(swap("voltage_2 [V]", "voltage_2 [kV]")(path.read_text())))
    assert [fault.row for fault in faults_of(folder)] == [1, 4]


def test_at_most_ten_faults_of_a_file_are_listed_in_the_order_of_its_rows(folder):
    rows = "".join(f"{t},x,0,0,y,0,0\n" for t in range(20))
    (folder / DRIVE).write_text(f"{HEADER}\n{rows}")
    *first, last = faults_of(folder)
    assert [fault.row for fault in first] == [2, 2, 3, 3, 4, 4, 5, 5, 6, 6]
    assert last.what == "and 30 more in this file"


def test_ten_faults_need_no_summary():
    fault = Fault(what="wrong", file="f", remedy="Mend it.")
    assert listed([fault] * 10, file="f") == (fault,) * 10


def test_a_fault_reads_as_one_sentence_and_a_remedy():
    fault = Fault(
        what="not a number",
        file="a/drive.csv",
        row=12,
        column="t [s]",
        got="'x'",
        expected="a finite decimal number",
        remedy="Correct the cell.",
    )
    assert str(fault) == (
        "a/drive.csv, row 12, column 't [s]': not a number, got 'x', "
        "expected a finite decimal number. Correct the cell."
    )


def test_a_campaigns_error_names_the_campaign_and_counts_the_faults(folder):
    (folder / RUN).unlink()
    with pytest.raises(ValueError, match=r"small: 1 fault\.\n  0001-step/run\.toml: the file"):
        read_campaign(folder)


# Writing and reading the files takes some 0.1 s an example.
@hypothesis.settings(max_examples=40)
@hypothesis.given(
    file=st.sampled_from([RIG, RUN, DRIVE, CAMERA]),
    start=st.integers(0, 300),
    length=st.integers(0, 12),
    new=st.binary(max_size=12) | st.text(",.\n\"'[]= 0e-nan", max_size=6).map(str.encode),
)
def test_whatever_is_damaged_the_doctor_says_so_and_never_fails(
    tmp_path_factory, file, start, length, new
):
    folder = good_campaign.write(tmp_path_factory.mktemp("campaign") / "small")
    content = (folder / file).read_bytes()
    (folder / file).write_bytes(content[:start] + new + content[start + length :])
    check = check_campaign(folder)
    if check.passed:
        assert len(read_campaign(folder).runs) == 2
    else:
        assert all(fault.remedy for fault in faults_of(folder))


def test_a_file_of_a_name_without_end_is_named_in_short():
    named = Fault(what="it can't be read", file="/logs/" + 9000 * "x", remedy="Check its name.")
    line = str(CampaignError("C", (named,))).splitlines()[1]
    assert line.startswith("  /logs/xxx")
    assert line.endswith("xxx: it can't be read. Check its name.")
    assert len(line) < 400
