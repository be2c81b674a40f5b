"""A store believes no bit that isn't its own."""

import contextlib
import pathlib
import shutil
import subprocess
import sys
import tempfile

import hypothesis
import numpy as np
import pytest
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from experiments.runtime.computation import Outcome
from experiments.runtime.executors.executor import Executor
from experiments.runtime.job import Job
from experiments.runtime.parcel import Parcel
from experiments.runtime.run import run
from experiments.runtime.store.lock import locked
from experiments.runtime.store.manifest import read_manifest
from experiments.runtime.store.store import claimed

UNITS = 4


def job(kind="one", count=UNITS):
    return Job("sweep", Parcel({"kind": kind}), count, {"jax": "1"}, payload)


def payload(number):
    return b"given %d" % number


def content(job, number):
    """What a unit comes to: another one for every job and unit."""
    return job.identity(number, payload(number)) * 20


class Honest(Executor):
    """Computes in no time, and counts what it was asked for."""

    @property
    def installation(self):
        return {"jax": "1"}

    def __init__(self, stop=None, fails=()):
        self.asked, self.stop, self.fails = [], stop, fails

    def outcomes(self, job, numbers):
        for number in numbers:
            if len(self.asked) == self.stop:
                raise KeyboardInterrupt
            self.asked.append(number)
            assert job.payload(number) == payload(number)
            if number in self.fails:
                yield number, Outcome(b"", "it can't be")
            else:
                yield number, Outcome(content(job, number))


def filled(folder, own, executor):
    """Run a job, and read what it comes to."""
    distrusted = []
    kind = {"kind": own.context.facts["kind"]}
    with claimed(folder, own, kind, distrusted.append) as store:
        failures = run(store, executor)
        found = [store.read(number, payload(number)) for number in range(own.count)]
    return found, distrusted, failures


def test_what_is_kept_is_not_computed_again(tmp_path):
    with contextlib.suppress(KeyboardInterrupt):
        filled(tmp_path / "store", job(), Honest(stop=2))
    second = Honest()
    found, distrusted, _ = filled(tmp_path / "store", job(), second)
    assert (second.asked, distrusted) == ([2, 3], [])
    assert found == [content(job(), number) for number in range(UNITS)]


def test_a_unit_that_fails_is_told_with_its_reason_and_the_rest_goes_on(tmp_path):
    found, _, failures = filled(tmp_path / "store", job(), Honest(fails=(1,)))
    assert failures == {1: "it can't be"}
    assert [own is None for own in found] == [False, True, False, False]
    again = Honest()
    filled(tmp_path / "store", job(), again)
    assert again.asked == [1]


def test_a_unit_that_is_given_something_else_is_computed_anew(tmp_path, monkeypatch):
    filled(tmp_path / "store", job(), Honest())
    changed = {2: b"new"}
    monkeypatch.setitem(globals(), "payload", lambda n: changed.get(n, b"given %d" % n))
    anew = Honest()
    _, distrusted, _ = filled(tmp_path / "store", job(), anew)
    assert anew.asked == [2]
    assert distrusted == [("00000002.unit", "of other inputs, or another unit's")]


def test_another_jobs_store_is_refused_by_what_differs(tmp_path):
    filled(tmp_path / "store", job(), Honest())
    with pytest.raises(ValueError, match=r"\(kind differ\)"):
        filled(tmp_path / "store", job("other"), Honest())
    with pytest.raises(ValueError, match=r"\(units differ\)"):
        filled(tmp_path / "store", job(count=5), Honest())


def test_a_file_of_somebody_elses_is_left_alone_and_refused(tmp_path):
    filled(tmp_path / "store", job(), Honest())
    (tmp_path / "store" / "00000004.unit").write_text("one too many")
    with pytest.raises(ValueError, match=r"'00000004\.unit'"):
        filled(tmp_path / "store", job(), Honest())
    assert (tmp_path / "store" / "00000004.unit").read_text() == "one too many"


def test_a_scratch_file_of_a_killed_writer_is_removed(tmp_path):
    filled(tmp_path / "store", job(), Honest())
    (tmp_path / "store" / ".scdpr-01234567-99-0123456789ab.tmp").write_text("half")
    with claimed(tmp_path / "store", job(), {"kind": "one"}) as store:
        assert not any(path.suffix == ".tmp" for path in store.folder.iterdir())
        store.remove()
    assert not (tmp_path / "store").exists()


HOLDER = """
import pathlib, sys
from experiments.runtime.store.lock import locked
with locked(pathlib.Path(sys.argv[1])):
    print("has it", flush=True)
    sys.stdin.read()
"""


def test_of_two_processes_one_has_the_folder_and_the_other_is_told(tmp_path):
    folder = tmp_path / "store"
    holder = subprocess.Popen(
        [sys.executable, "-c", HOLDER, str(folder)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    )
    with holder:
        assert holder.stdout.readline() == b"has it\n"
        with pytest.raises(ValueError, match="another process is at it"):
            filled(folder, job(), Honest())
        holder.kill()
    # A process that was killed has it no longer.
    filled(folder, job(), Honest())


def test_a_folder_that_was_removed_meanwhile_is_made_anew(tmp_path):
    with locked(tmp_path / "store"):
        (tmp_path / "store" / "lock").unlink()
        (tmp_path / "store").rmdir()
        with locked(tmp_path / "store"):
            assert (tmp_path / "store" / "lock").exists()


# Corruption


def corrupted(folder, random):
    """Do one thing to one file of a store that nobody should; name the file."""
    files = sorted(path for path in folder.iterdir() if path.name != "lock")
    path = files[random.integers(len(files))]
    whole = path.read_bytes()
    kind = random.choice(["flip", "cut", "append", "exchange", "remove", "zero"])
    if kind == "flip":
        bit = int(random.integers(8 * len(whole)))
        changed = bytearray(whole)
        changed[bit // 8] ^= 1 << bit % 8
        path.write_bytes(changed)
    elif kind == "cut":
        path.write_bytes(whole[: random.integers(len(whole))])
    elif kind == "append":
        path.write_bytes(whole + random.bytes(int(random.integers(1, 99))))
    elif kind == "zero":
        begin = int(random.integers(len(whole) - 1))
        path.write_bytes(whole[:begin] + bytes(len(whole) - begin))
    elif kind == "remove":
        path.unlink()
    else:
        other = path.with_name(files[random.integers(len(files))].name)
        if other == path:
            other = folder.parent / "foreign" / path.name
        theirs = other.read_bytes()
        if other.parent == folder:
            other.write_bytes(whole)
        path.write_bytes(theirs)
    return kind


def is_anothers(folder):
    """Whether a folder has another job's manifest, and a whole one."""
    began = read_manifest(folder)
    return began is not None and began["key"] != job().key.hex()


def survives(folder, count, seed):
    """Corrupt a store again and again; how often what came of it was wrong."""
    random, kinds = np.random.default_rng(seed), {}
    filled(folder.parent / "foreign", job("other"), Honest())
    expected = [content(job(), number) for number in range(UNITS)]
    for _ in range(count):
        found, _, _ = filled(folder, job(), Honest())
        assert found == expected
        before = {path.name: path.read_bytes() for path in folder.iterdir()}
        kind = corrupted(folder, random)
        changed = {path.name for path in folder.iterdir()} ^ set(before)
        changed |= {
            path.name
            for path in folder.iterdir()
            if path.name in before and path.read_bytes() != before[path.name]
        }
        kind = str(kind)
        kinds[kind] = kinds.get(kind, 0) + 1
        anew = Honest()
        if is_anothers(folder):
            with pytest.raises(ValueError, match="keeps what another call has begun"):
                filled(folder, job(), anew)
            shutil.rmtree(folder)
            continue
        found, distrusted, _ = filled(folder, job(), anew)
        assert found == expected
        units = {name for name in changed if name.endswith(".unit")}
        assert {f"{number:08d}.unit" for number in anew.asked} == units
        there = units & {path.name for path in folder.iterdir()}
        if kind != "remove":
            assert {each.name for each in distrusted} == there | (changed - units)
    return kinds


def test_every_corruption_is_found_named_and_computed_anew(tmp_path):
    assert sum(survives(tmp_path / "store", 60, seed=1).values()) == 60


@pytest.mark.slow
def test_every_one_of_a_thousand_corruptions_is_found(tmp_path):
    kinds = survives(tmp_path / "store", 1000, seed=2)
    print(kinds)
    assert sum(kinds.values()) == 1000


class StoreOnItsWay(RuleBasedStateMachine):
    """Whatever is done to a store between its calls, it ends with what it is of."""

    @initialize()
    def begin(self):
        self.root = pathlib.Path(tempfile.mkdtemp())
        self.folder = self.root / "store"
        filled(self.root / "foreign", job("other"), Honest())

    def refused_where_it_is_anothers(self):
        """What a call comes to where somebody has exchanged the manifest."""
        if is_anothers(self.folder):
            return pytest.raises(ValueError, match="another call has begun")
        return contextlib.nullcontext()

    @rule(units=st.integers(0, UNITS))
    def work_until_it_is_stopped(self, units):
        with contextlib.suppress(KeyboardInterrupt), self.refused_where_it_is_anothers():
            filled(self.folder, job(), Honest(stop=units))

    @rule(fails=st.sets(st.integers(0, UNITS - 1)))
    def some_units_fail(self, fails):
        with self.refused_where_it_is_anothers():
            filled(self.folder, job(), Honest(fails=fails))

    @rule(seed=st.integers(0, 2**32 - 1))
    def somebody_corrupts_it(self, seed):
        if self.folder.exists() and len(list(self.folder.iterdir())) > 1:
            with contextlib.suppress(FileNotFoundError):  # Nothing to exchange with.
                corrupted(self.folder, np.random.default_rng(seed))

    @rule()
    def another_job_comes(self):
        whole = self.folder.exists() and any(self.folder.glob("*.json"))
        if not whole:
            return
        with contextlib.suppress(ValueError):
            filled(self.folder, job("third"), Honest())

    @invariant()
    def it_ends_with_what_it_is_of(self):
        if not hasattr(self, "root"):
            return
        copy = self.root / "copy"
        if self.folder.exists():
            shutil.copytree(self.folder, copy)
        if is_anothers(copy):
            with pytest.raises(ValueError, match="another call has begun"):
                filled(copy, job(), Honest())
        else:
            found, _, _ = filled(copy, job(), Honest())
            assert found == [content(job(), number) for number in range(UNITS)]
        shutil.rmtree(copy)

    def teardown(self):
        if hasattr(self, "root"):
            shutil.rmtree(self.root)


TestStoreOnItsWay = StoreOnItsWay.TestCase
TestStoreOnItsWay.settings = hypothesis.settings(
    max_examples=6, stateful_step_count=6, deadline=None, derandomize=True
)
