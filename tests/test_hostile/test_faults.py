"""Disks that are full, folders that are closed, signals: a line, the status, nothing left."""

import errno
import os
import pathlib
import signal
import stat
import subprocess
import sys
import time

import given_files
import pytest

from experiments.cli import main
from experiments.verbs.exit_status import BAD_INPUT
from experiments.verbs.places import try_out
from identification.campaign import read_campaign, write_campaign
from scdpr_jax.numerics.files import scratch, whole_file, write_whole

SCDPR = [sys.executable, "-c", "from experiments.cli import main; main()"]
"""The command, in a process that is its own."""


def everything(folder):
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))


@pytest.fixture
def full(monkeypatch):
    """A disk on which nothing has room."""

    def no_room(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(pathlib.Path, "write_bytes", no_room)


def test_a_full_disk_leaves_the_old_file_and_names_it(tmp_path, full):
    (tmp_path / "out.csv").write_text("old")
    with pytest.raises(OSError, match="No space") as caught:
        write_whole(tmp_path / "out.csv", "new")
    assert caught.value.filename == str(tmp_path / "out.csv")
    assert everything(tmp_path) == ["out.csv"]
    assert (tmp_path / "out.csv").read_text() == "old"


def test_an_error_of_another_file_keeps_its_name(tmp_path):
    def reads_another():
        with whole_file(tmp_path / "out.csv"):
            (tmp_path / "gone").read_text()

    with pytest.raises(FileNotFoundError) as caught:
        reads_another()
    assert caught.value.filename == str(tmp_path / "gone")


def test_out_is_tried_where_the_disk_is_full(tmp_path, full):
    with pytest.raises(ValueError, match="No space left"):
        try_out(tmp_path / "a" / "b" / "report.html")
    assert everything(tmp_path) == []


def test_trying_leaves_nothing(tmp_path):
    try_out(tmp_path / "a" / "b" / "report.html", tmp_path / "c.csv")
    assert everything(tmp_path) == []


@pytest.mark.parametrize("made", ["a folder", "a file in its folder's place"])
def test_out_is_tried_where_something_is_in_its_place(made, tmp_path):
    place = tmp_path / "out"
    place.mkdir() if made == "a folder" else place.write_text("mine")
    with pytest.raises(ValueError, match="`--out`"):
        try_out(place if made == "a folder" else place / "report.html")
    assert everything(tmp_path) == ["out"]


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_out_is_tried_in_a_closed_folder(tmp_path):
    (tmp_path / "closed").mkdir(mode=0o500)
    with pytest.raises(ValueError, match="Permission denied"):
        try_out(tmp_path / "closed" / "report.html")


LONG = {
    "calibrate": "{good}/campaign",
    "identify": "{good}/campaign",
    "frequencies": "{good}/campaign",
    "identify-drive": "{good}/axis.csv --gain=35_N/V",
    "tune": "--parameters={good}/none --frequencies={good}/none",
    "shape": "{good}/spectrum.csv",
    "codesign": "{good}/none",
    "design": "{good}/none --for=mu",
    "simulate": "--parameters={good}/none",
    "track": "{good}/vision.toml",
    "plan": "{good}/none --to=1.9_m,0.55_m",
    "sweep": "frequency --over=y=0.2..0.9:5_m",
    "reproduce": "",
    "benchmark": "",
    "demo": "",
}
"""Calls of verbs that compute for long; a blank is written as _."""


@pytest.mark.parametrize("verb", LONG)
def test_every_long_verb_tries_out_first(verb, tmp_path, capfd):
    given_files.write(tmp_path / "good")
    (tmp_path / "file").write_text("mine")
    call = LONG[verb].format(good=tmp_path / "good").split()
    out = tmp_path / "file" / "out.csv"
    words = [word.replace("_", " ") if "=" in word else word for word in call]
    assert main([verb, *words, "--out", str(out)]) == BAD_INPUT
    told = capfd.readouterr().err
    assert told.startswith(f"scdpr {verb}: `--out`")
    assert "a file in its folder's place" in told


def test_results_have_the_permissions_that_the_users_mask_leaves(tmp_path):
    given_files.write(tmp_path / "good")
    before = os.umask(0o027)
    try:
        write_whole(tmp_path / "out" / "a.csv", "1")
        write_campaign(read_campaign(tmp_path / "good" / "campaign"), tmp_path / "copy")
    finally:
        os.umask(before)
    modes = {
        path.name: stat.S_IMODE(path.stat().st_mode)
        for path in (tmp_path / "out" / "a.csv", tmp_path / "copy" / "campaign.toml")
    }
    assert modes == {"a.csv": 0o640, "campaign.toml": 0o640}
    assert stat.S_IMODE((tmp_path / "copy").stat().st_mode) == 0o750


def test_what_a_killed_process_has_left_is_removed_by_the_next(tmp_path):
    own = scratch._name(tmp_path).name
    # No system has so many processes.
    left = tmp_path / own.replace(f"-{os.getpid()}-", f"-{2**30}-")
    left.write_text("half")
    of_another_machine = tmp_path / ".scdpr-00000000-1-abc.tmp"
    of_another_machine.write_text("half")
    with scratch.scratch_file(tmp_path / "a.csv"):
        pass
    assert everything(tmp_path) == [of_another_machine.name]


WAITS = """
import sys, time, pathlib
from experiments.verbs import ending
from scdpr_jax.numerics.files import whole_file
from scdpr_jax.numerics.files.scratch import TOGETHER

class Cleaned:
    def __del__(self):
        print("waits", flush=True)
        time.sleep(60)

def together():
    with TOGETHER:
        print("waits", flush=True)
        time.sleep(0.3)
        pathlib.Path(sys.argv[1], "whole").write_text("1")
    time.sleep(60)

def in_python(seconds=60):
    print("waits", flush=True)
    time.sleep(seconds)

ending.end_on_signals("sleep")
with whole_file(pathlib.Path(sys.argv[1], "half.csv")) as scratch:
    scratch.write_text("half")
    {doing}
"""
# Who runs the tests may have been begun deaf to Ctrl-C, as in the background of a shell.
HEARS = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
DOING = {"in Python": "in_python()", "in clean-up": "Cleaned()", "at renames": "together()"}


def begun(script, folder):
    call = [sys.executable, "-c", script, str(folder)]
    pipe = subprocess.PIPE
    return subprocess.Popen(call, stdout=pipe, stderr=pipe, text=True)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such signals")
@pytest.mark.parametrize("doing", DOING)
@pytest.mark.parametrize(
    ("number", "word"),
    [(signal.SIGINT, "stopped"), (signal.SIGTERM, "terminated"), (signal.SIGHUP, "gone")],
)
def test_a_signal_ends_the_process_with_one_line(number, word, doing, tmp_path):
    child = begun(HEARS + WAITS.format(doing=DOING[doing]), tmp_path)
    assert child.stdout.readline() == "waits\n"
    child.send_signal(number)
    _, told = child.communicate(timeout=60)
    assert child.returncode == 128 + number
    (line,) = told.splitlines()
    assert line.startswith("scdpr sleep: ")
    assert word in line
    assert everything(tmp_path) == (["whole"] if doing == "at renames" else [])


INTERRUPTED = """
import sys
from experiments import cli

class Interrupted:
    def find_spec(self, name, path, target=None):
        if name == "experiments.verbs.ending":
            raise KeyboardInterrupt

sys.meta_path.insert(0, Interrupted())
cli.main()
"""


def test_ctrl_c_while_the_command_is_loading_is_one_line(tmp_path):
    child = begun(INTERRUPTED, tmp_path)
    _, told = child.communicate(timeout=60)
    assert child.returncode == 130
    assert told.splitlines() == ["scdpr: stopped. No file is half written."]


def test_who_is_begun_deaf_stays_deaf(tmp_path):
    script = WAITS.format(doing="in_python(1)")
    deaf = "import signal, sys; signal.signal(signal.SIGINT, signal.SIG_IGN)\n"
    child = begun(deaf + script, tmp_path)
    child.stdout.readline()
    child.send_signal(signal.SIGINT)
    child.communicate(timeout=60)
    assert child.returncode == 0
    assert everything(tmp_path) == ["half.csv"]


@pytest.mark.skipif(sys.platform != "linux", reason="/dev/full is Linux's")
@pytest.mark.parametrize("verb", ["--help", "--version"])
def test_output_that_has_no_room_is_told(verb, tmp_path):
    # A width that a test has set is nobody's terminal.
    clean = {name: own for name, own in os.environ.items() if name != "COLUMNS"}
    with open("/dev/full", "w") as full_disk:
        ended = subprocess.run([*SCDPR, verb], stdout=full_disk, stderr=subprocess.PIPE,
                               text=True, check=False, env=clean)  # fmt: skip
    assert ended.returncode == BAD_INPUT
    assert len(ended.stderr.splitlines()) == 1


@pytest.mark.slow
@pytest.mark.parametrize("verb", ["identify", "frequencies", "shape", "sweep"])
def test_ctrl_c_at_any_moment_is_one_line(verb, tmp_path):
    given_files.write(tmp_path / "good")
    words = LONG[verb].format(good=tmp_path / "good").split()
    call = [*SCDPR, verb, *(w.replace("_", " ") if "=" in w else w for w in words)]
    for moment in range(12):
        out = tmp_path / "out" / f"{moment}.nc"
        child = subprocess.Popen([*call, "--out", str(out)], stdout=subprocess.DEVNULL,
                                 stderr=subprocess.PIPE, text=True)  # fmt: skip
        time.sleep(0.3 + 0.3 * moment)
        child.send_signal(signal.SIGINT)
        _, told = child.communicate(timeout=60)
        if child.returncode == 130:
            assert told.splitlines()[-1].startswith(f"scdpr {verb}: stopped.")
            assert "Traceback" not in told
        assert not list(tmp_path.rglob(".scdpr-*"))
