"""The planner in C, compiled: it plans what Python plans, and bears bad calls."""

import ctypes
import importlib.util
import math
import pathlib
import shutil
import subprocess
import sys

import numpy as np
import pytest

from scdpr_jax.command.controller import PD
from scdpr_jax.legs.random_legs import random_legs
from scdpr_jax.robot.parameters import exact
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace
from tuning.plan.planning import plan_leg, resting_start

NUMBERS = {
    "effective_pretension": 95.0,
    "friction_coefficient": 0.015,
    "drive_inertia": 0.0138,
    "drive_damping": 0.205,
    "drive_compliance": 1.5e-5,
}


ROBOT, CONTROLLER = exact(replace(consistent(), NUMBERS)), PD(34.46, 1.96)
COMPILER = shutil.which("cc")
STRICT = ["-std=c99", "-O2", "-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Werror"]
HEIGHT = float(ROBOT.frame.height)
# A file of the caller's, for what a library's user knows at compile time.
SIZE = """\
#include "scdpr_leg.h"
long leg_size(void);
long leg_size(void) { return sizeof(scdpr_leg); }
"""

pytestmark = pytest.mark.skipif(COMPILER is None, reason="there is no C compiler, `cc`, here")


WRITE = """
import pathlib, sys
import jax
jax.config.update("jax_enable_x64", True)
sys.path.insert(0, sys.argv[2])
import test_onboard as given
from tuning.export.onboard.files import onboard_files
from tuning.export.onboard.program import OnBoard
for name, text in onboard_files(OnBoard(given.ROBOT, given.CONTROLLER)).items():
    pathlib.Path(sys.argv[1], name).write_text(text)
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The files, written by a process without the tests' type checks: five times as fast."""
    where = tmp_path_factory.mktemp("onboard")
    here = str(pathlib.Path(__file__).parent)
    subprocess.run([sys.executable, "-c", WRITE, str(where), here], check=True)
    assert {path.name for path in where.iterdir()} == {
        "README.md",
        "example.c",
        "scdpr_leg.c",
        "scdpr_leg.h",
        "selftest.c",
    }
    (where / "size.c").write_text(SIZE)
    return where


def build(folder, *arguments, strict=tuple(STRICT), compiler=(COMPILER,)):
    made = subprocess.run(
        [*compiler, *strict, *arguments, "-lm"], cwd=folder, capture_output=True, text=True
    )
    assert made.returncode == 0, made.stderr[-3000:]


class Planner:
    """The compiled planner."""

    def __init__(self, library):
        number, pointer = ctypes.c_double, ctypes.c_void_p
        self.of = ctypes.CDLL(str(library))
        self.of.leg_size.restype = ctypes.c_long
        self.of.scdpr_leg_begin.argtypes = [pointer, pointer, number, number, number]
        self.of.scdpr_leg_work.argtypes = [pointer, ctypes.c_int]
        self.of.scdpr_leg_at.argtypes = [pointer, number, pointer, pointer]
        self.of.scdpr_leg_vibration.argtypes = [pointer, pointer]
        self.of.scdpr_leg_time.argtypes = [pointer]
        self.of.scdpr_leg_vibration.restype = self.of.scdpr_leg_time.restype = number
        self.memory = np.zeros(self.of.leg_size() // 8 + 1)
        self.leg = self.memory.ctypes.data

    def begin(self, state, x, y, time):
        state = np.array(state, float)
        return self.of.scdpr_leg_begin(self.leg, state.ctypes.data, x, y, time)

    def work(self, linearisations=1):
        return self.of.scdpr_leg_work(self.leg, linearisations)

    def at(self, time):
        told = np.empty(4)
        self.of.scdpr_leg_at(self.leg, time, told.ctypes.data, told[2:].ctypes.data)
        return told

    def vibration(self):
        worst = np.empty(1)
        return self.of.scdpr_leg_vibration(self.leg, worst.ctypes.data), worst[0]

    def time(self):
        return self.of.scdpr_leg_time(self.leg)


@pytest.fixture(scope="module")
def planner(folder):
    build(folder, "-shared", "-fPIC", "scdpr_leg.c", "size.c", "-o", "leg.so")
    return Planner(folder / "leg.so")


def standing(x, y, slope):
    return [x, math.atan(slope), x + slope * y, x - slope * (HEIGHT - y), y]


def compared(planner, legs):
    """Legs that differ: each angle within 1e-6 rad, each command within 1e-3 V."""
    different = []
    for row in range(len(legs)):
        slope = float(legs.out_of_line[row]) * 0.015
        state = standing(*legs.start[row], slope)
        end, time = tuple(map(float, legs.end[row])), float(legs.time[row])
        assert planner.begin(state, *end, time) == 0
        while (code := planner.work(5)) == 0:
            pass
        assert code == 1
        place, told = resting_start(ROBOT, state)
        start = place if slope else tuple(map(float, legs.start[row]))
        made = plan_leg(
            ROBOT, CONTROLLER, start, end, leg_time=time, slope=told if slope else None
        )
        rows = np.array([planner.at(t) for t in made.plan.time])
        off = (
            np.max(np.abs(rows[:, :2] - made.plan.angle)),
            np.max(np.abs(rows[:, 2:] - made.plan.feedforward)),
        )
        expected = made.expected.vibration[0], made.expected.worst
        if off[0] > 1e-6 or off[1] > 1e-3:
            different.append((row, off, planner.vibration(), expected))
        else:
            assert planner.vibration() == pytest.approx(expected, rel=1e-3, abs=1e-7)
            assert planner.time() == pytest.approx(made.leg.time, abs=1e-12)
    return different


@pytest.mark.slow
def test_a_few_legs_are_planned_as_python_plans_them(planner):
    legs = random_legs(ROBOT.frame, 3, seed=7, leg_times=(0.9, 1.6))
    assert not compared(planner, legs)


@pytest.mark.slow
def test_of_a_hundred_legs_ninety_five_are_planned_as_python_plans_them(planner):
    different = compared(planner, random_legs(ROBOT.frame, 100, seed=8))
    assert len(different) <= 5
    for _, _, own, expected in different:
        assert own == pytest.approx(expected, rel=0.05, abs=5e-5)


def test_the_example_and_the_self_test_compile_and_pass(folder):
    for name in ("example", "selftest"):
        build(folder, f"{name}.c", "scdpr_leg.c", "-o", name)
    told = subprocess.run([folder / "selftest"], capture_output=True, text=True)
    assert told.returncode == 0, told.stdout
    assert "DIFFERS" not in told.stdout
    rows = subprocess.run([folder / "example"], capture_output=True, text=True, check=True)
    table = np.genfromtxt(rows.stdout.splitlines()[2:], delimiter=",")
    assert np.all(np.isfinite(table))
    assert table[-1, 3:].tolist() == [0.0, 0.0]


def test_from_the_first_call_on_there_is_a_leg_that_can_be_driven(planner):
    assert planner.begin(standing(0.5, 0.5, 0.0), 1.4, 0.6, 2.0) == 0
    radius = float(ROBOT.drive.effective_radius)
    arrival = np.array([0.9 + 0.1, 0.9 - 0.1]) / radius
    before = planner.vibration()[0]
    for _ in range(60):
        np.testing.assert_allclose(planner.at(0.0)[:2], 0.0, atol=1e-12)
        # Cables that give are ahead by what friction holds, 4 N, at the most.
        np.testing.assert_allclose(planner.at(planner.time() + 1.0)[:2], arrival, atol=1e-3)
        # What is known of the fitted robot never gets worse but by what others gain.
        assert planner.vibration()[0] <= max(before, 0.3e-3)
        if planner.work() == 1:
            break


HOSTILE = {
    "not a number": ([math.nan, 0, 0.5, 0.5, 0.5], 1.0, 0.5, 2.0, -1),
    "endless": ([0.5, 0, 0.5, 0.5, 0.5], math.inf, 0.5, 2.0, -1),
    "out of the frame": ([0.5, 0, 0.5, 0.5, 0.5], 3.0, 0.5, 2.0, -2),
    "above the guide": ([0.5, 0, 0.5, 0.5, 1.2], 1.0, 0.5, 2.0, -2),
    "no time": ([0.5, 0, 0.5, 0.5, 0.5], 1.0, 0.5, 0.0, -3),
    "too much time": ([0.5, 0, 0.5, 0.5, 0.5], 1.0, 0.5, 100.0, -3),
    "in millimetres": ([500.0, 0, 500.0, 500.0, 500.0], 1.0, 0.5, 2.0, -2),
    "not at rest": ([0.5, 0, 0.6, 0.4, 0.5], 1.0, 0.5, 2.0, -4),
    "nowhere": ([0.5, 0, 0.5, 0.5, 0.5], 0.5, 0.5, 2.0, -5),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_a_call_that_makes_no_sense_has_a_code_of_its_own(planner, name):
    *call, code = HOSTILE[name]
    assert planner.begin(*call) == code
    assert planner.work() == -6
    assert planner.at(0.5).tolist() == [0, 0, 0, 0]
    assert math.isnan(planner.vibration()[0])


SANITIZERS = ["-std=c99", "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
HOSTILE_CALLS = r"""
#include "scdpr_leg.h"
#include <math.h>
#include <stdio.h>
static scdpr_leg leg;
static unsigned long seed = 1;
static double uniform(void)
{
    seed = seed * 6364136223846793005UL + 1442695040888963407UL;
    return (double)(seed >> 40) / (double)(1UL << 24);
}
static double any(double usual)
{
    static const double odd[] = {0, -1, 1e300, -1e300, 1e-300, 3e9};
    double u = uniform();
    return u < 0.05 ? NAN : u < 0.1 ? INFINITY : u < 0.15 ? odd[(int)(6 * uniform())]
         : usual * (0.5 + uniform());
}
int main(void)
{
    int planned = 0;
    for (int i = 0; i < 1000; i++) {
        double state[5], angle[2], volts[2], worst;
        for (int k = 0; k < 5; k++)
            state[k] = k == 1 ? 0 : i % 3 ? any(0.6) : 0.6;
        int code = scdpr_leg_begin(&leg, state, any(1.0), any(0.5), i % 5 ? any(1.0) : 0.9);
        if (code == 0)
            code = scdpr_leg_work(&leg, i % 50 ? (int)(3 * uniform()) : 1000);
        planned += code >= 0;
        scdpr_leg_at(&leg, any(1.0), angle, volts);
        for (int k = 0; k < 2; k++)
            if (!isfinite(angle[k]) || !isfinite(volts[k]))
                return 1;
        scdpr_leg_vibration(&leg, i % 2 ? &worst : 0);
        if (!scdpr_leg_message(code) || !(scdpr_leg_time(&leg) >= 0))
            return 2;
    }
    printf("%d\n", planned);
    return planned < 20;
}
"""


@pytest.mark.slow
def test_a_thousand_hostile_calls_are_borne_under_sanitizers(folder):
    (folder / "hostile.c").write_text(HOSTILE_CALLS)
    build(folder, "hostile.c", "scdpr_leg.c", "-o", "hostile", strict=SANITIZERS)
    done = subprocess.run([folder / "hostile"], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr[-3000:]


def compiler_for_32_bits():
    """The compiler here where it has headers for 32 bits, or Zig's, which brings its own."""
    empty = subprocess.run(
        [COMPILER, "-m32", "-E", "-x", "c", "-"],
        input=b"#include <math.h>\n",
        capture_output=True,
    )
    if not empty.returncode:
        return [COMPILER, "-m32"]
    if importlib.util.find_spec("ziglang") is None:
        pytest.skip("no compiler for 32 bits here: run with `uv run --with ziglang pytest`")
    return [sys.executable, "-m", "ziglang", "cc", "-target", "x86-linux-musl"]


@pytest.mark.slow
def test_it_plans_the_same_in_32_bits(folder):
    compiler = compiler_for_32_bits()
    files = ("selftest.c", "scdpr_leg.c", "-o", "selftest32")
    build(folder, *files, strict=(*STRICT, "-msse2", "-mfpmath=sse"), compiler=compiler)
    done = subprocess.run([folder / "selftest32"], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
    assert done.stdout.count("as Python plans it") == 3


@pytest.mark.slow
def test_what_keeps_more_digits_than_a_double_has_is_refused_with_a_remedy(folder):
    without = ["-march=i686", "-mno-sse", "-c", "scdpr_leg.c", "-o", "never.o"]
    made = subprocess.run(
        [*compiler_for_32_bits(), *without], cwd=folder, capture_output=True, text=True
    )
    assert made.returncode != 0
    assert "-msse2 -mfpmath=sse" in made.stderr
