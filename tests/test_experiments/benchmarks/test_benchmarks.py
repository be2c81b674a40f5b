"""Tests of `experiments.benchmarks`."""

import json

import diffrax
import jax.numpy as jnp
import numpy as np
import pytest

from experiments.benchmarks import report, rows
from experiments.benchmarks.line import Line, Settings
from experiments.benchmarks.measurements import timing
from experiments.benchmarks.measurements.batched import batched
from experiments.benchmarks.measurements.timing import fastest, interleaved
from experiments.benchmarks.peers import casadi_peer, mujoco_peer
from experiments.benchmarks.peers.diffrax_peers import Smoothed
from experiments.benchmarks.peers.smoothed_robot import slope
from experiments.benchmarks.problem import MIDDLE, SPREAD, drawn, error
from experiments.verbs.study.benchmark import Row


def test_calls_take_turns_and_the_first_of_each_is_apart():
    order = []
    calls = {name: lambda name=name: order.append(name) or 0.0 for name in ("a", "b")}
    interleaved(calls, repeats=2)
    assert order == ["a", "b", "a", "b", "a", "b"]


class Clock:
    """A clock that goes on only when told to."""

    def __init__(self):
        self.now = 0.0

    def perf_counter(self):
        return self.now

    def taking(self, *times):
        """A call that takes these times, one after the other, and the last one for ever."""
        left = list(times)

        def call():
            self.now += left.pop(0) if len(left) > 1 else left[0]
            return 7.0

        return call


@pytest.fixture
def clock(monkeypatch):
    clock = Clock()
    monkeypatch.setattr(timing, "time", clock)
    return clock


def test_compilation_is_what_the_first_call_takes_longer_than_the_median(clock):
    timed = interleaved({"it": clock.taking(5.0, 1.0, 9.0, 2.0)}, repeats=3)["it"]
    assert timed.result == 7.0
    assert timed.median == 2.0
    assert timed.compile == 3.0


def test_fastest_is_by_the_compiled_time(clock):
    calls = {1: clock.taking(0.0, 2.0), 2: clock.taking(50.0, 1.0)}
    assert fastest(calls) == 2


@pytest.mark.parametrize("chunk", [1, 3, 7, 20])
def test_every_chunk_gives_the_functions_results(chunk):
    points = np.arange(7.0)
    np.testing.assert_array_equal(batched(jnp.square, points, chunk=chunk), points**2)


def test_runs_are_the_same_whatever_their_number():
    np.testing.assert_array_equal(drawn(3), drawn(8)[:3])
    assert (np.abs(drawn(100) / MIDDLE - 1) <= SPREAD).all()


def test_error_counts_a_tilt_as_the_attachments_way():
    off = np.zeros((4, 5))
    off[2, 1] = 0.01
    assert error(off, np.zeros((4, 5))) == pytest.approx(0.001405)


def test_every_row_can_be_asked_for():
    assert tuple(name for name, _ in rows.ROWS) == Row.__args__


def test_what_is_not_run_stands_in_the_table_with_its_reason(tmp_path):
    lines = [
        Line("forward", "this", 64, 0.004, 32000.0, "robot-s", 2.0, "40.00 × Tsit5", "1e-6 m"),
        Line("forward", "MuJoCo", 1, note="not run: mujoco isn't installed"),
    ]
    readable, exact = report.write(tmp_path, lines, report.machine(), Settings(3, 64))
    text = readable.read_text(encoding="utf-8")
    assert "| forward | this | 64 | 4 ms | 3.2e+04 robot-s/s | 2 s | 40.00 × Tsit5 |" in text
    assert "not run: mujoco isn't installed" in text
    document = json.loads(exact.read_text(encoding="utf-8"))
    assert document["lines"][0]["rate"] == 32000.0
    assert document["machine"]["jax"]
    assert document["settings"] == {"repeats": 3, "largest_batch": 64}


@pytest.mark.skipif(bool(casadi_peer.missing()), reason=casadi_peer.missing())
def test_casadis_equations_and_runs_are_those_of_the_smoothed_robot():
    equations, random = casadi_peer.slope_in_casadi(), np.random.default_rng(0)
    for values in drawn(5):
        state = np.array([0.5, 0.0, 0.5, 0.5, 0.4, *[0.0] * 5]) + 0.1 * random.normal(size=10)
        voltage = 3 * random.normal(size=2)
        expected = np.asarray(slope(*map(jnp.asarray, (state, values, voltage))))
        found = np.asarray(equations(state, values, voltage)).ravel()
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)
        own = Smoothed(diffrax.Tsit5(), 1e-8)(jnp.asarray(values))
        assert error(casadi_peer.run(values), np.asarray(own)) <= 1e-4


def test_a_peer_that_is_not_here_says_so(monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert "extra of that name" in casadi_peer.missing()


@pytest.mark.skipif(bool(mujoco_peer.missing()), reason=mujoco_peer.missing())
def test_mujocos_robot_is_this_one():
    from experiments.benchmarks.peers.engines import NonlinearEngine

    values = drawn(1)
    truth = np.asarray(batched(NonlinearEngine(), values, chunk=1))[0]
    # Its friction is regularised; ../shared's ENGINE puts it at half a millimetre.
    assert error(mujoco_peer.run(values[0]), truth) <= 1e-3
