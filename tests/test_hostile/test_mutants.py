"""Files that were damaged at random, over every reader: one kind of error, and no hang."""

import faulthandler
import shutil

import given_files
import pytest
from mutants import mutant

from identification.bring.files.csv.dialect import Dialect
from identification.bring.files.open import open_logs
from scdpr_jax.numerics.files.harmless import LINES, printable

OURS = ("identification", "tuning", "scdpr_jax")
"""Packages whose errors may come out of a reader, beside a plain ValueError."""
LONGEST = 1500
"""Characters of a line of a message."""
HANG = 60.0
"""Time from which a reader hangs [s]; a machine may be busy."""


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    folder = given_files.write(tmp_path_factory.mktemp("good"))
    given_files.write_results(folder)
    return folder


def judge(error: ValueError) -> None:
    """Whether an error is of the one kind, and can be shown."""
    kind, lines = type(error), str(error).split("\n")
    assert kind is ValueError or kind.__module__.split(".")[0] in OURS
    assert len(lines) <= LINES
    assert all(printable(line) == line and len(line) < LONGEST for line in lines)


def fuzz(given, good, seeds):
    """Reads mutants, each within the time of a hang."""
    path = good / given.file
    content = path.read_bytes()
    for seed in seeds:
        path.write_bytes(mutant(content, seed))
        faulthandler.dump_traceback_later(HANG, exit=True)
        try:
            given.read(good)
        except ValueError as error:
            judge(error)
        finally:
            faulthandler.cancel_dump_traceback_later()
    path.write_bytes(content)


EVERY = (*given_files.TEXTS, *given_files.RESULTS)
every = pytest.mark.parametrize("given", EVERY, ids=lambda given: given.name.replace("/", "-"))


@every
def test_a_good_file_is_read(given, good):
    given.read(good)


@every
def test_a_mutant_is_read_or_refused_in_one_way(given, good):
    fuzz(given, good, range(given_files.IN_CI.get(given.name, 15)))


@pytest.mark.slow
@every
def test_thousands_of_mutants_are_read_or_refused_in_one_way(given, good):
    fuzz(given, good, range(10_000, 14_000))


def opened(good, folder, seeds):
    """Mutants whose reader is a child process: each is a log or a fault."""
    paths = []
    for name in given_files.BINARY:
        content = (good / name).read_bytes()
        for seed in seeds:
            paths.append(folder / f"{seed}-{name}")
            paths[-1].write_bytes(mutant(content, seed))
    logs, faults = open_logs([(path, Dialect()) for path in paths])
    assert len(logs) + len(faults) == len(paths)
    assert {fault.file for fault in faults} == {str(p) for p in paths if p not in logs}
    assert all(printable(str(fault)) == str(fault) for fault in faults)
    shutil.rmtree(folder)


def test_a_binary_mutant_is_a_log_or_a_fault(good, tmp_path):
    opened(good, tmp_path, range(4))


@pytest.mark.slow
@pytest.mark.parametrize("first", range(1000, 3000, 100))
def test_thousands_of_binary_mutants_are_logs_or_faults(first, good, tmp_path):
    opened(good, tmp_path, range(first, first + 100))
