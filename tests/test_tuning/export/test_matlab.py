"""The exported MATLAB script: its literals, its formulas, and Octave's run of it."""

import re
import shutil
import subprocess

import control
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tunings import NAMES, TUNINGS

from scdpr_jax.command.shaper import shape_samples
from tuning.export.description import describe
from tuning.export.matlab import FILE, matlab_script
from tuning.loop.responses import sampled_loop

OCTAVE = shutil.which("octave-cli") or shutil.which("octave")
LITERAL = re.compile(r"^(\w+) = (-?[\d.]+);", re.MULTILINE)
VECTOR = re.compile(r"^shapers\((\d+)\)\.(\w+) = \[([-\d., ]+)\];", re.MULTILINE)
FORMULA = re.compile(r"^(\w+) = (tf\(.+\));$", re.MULTILINE)


@pytest.fixture(params=TUNINGS, ids=NAMES)
def tuning(request):
    return request.param


@pytest.fixture
def script(tuning):
    return matlab_script(describe(tuning))


def literals(script):
    return {name: float(value) for name, value in LITERAL.findall(script)}


def vectors(script):
    """Each shaper's fields, by number."""
    found = {}
    for number, field, cells in VECTOR.findall(script):
        found.setdefault(int(number), {})[field] = [float(cell) for cell in cells.split(",")]
    return found


def systems(script):
    """What its lines with `tf` say, which read the same in Python."""
    names = literals(script)
    return {
        name: eval(formula, {"tf": control.tf}, names)
        for name, formula in FORMULA.findall(script)
    }


def test_literals_are_the_tunings_numbers_to_the_last_bit(script, tuning):
    description = describe(tuning)
    expected = vars(description.constants) | {
        "plant_gain": float(description.plant.gain),
        "plant_pole": float(description.plant.pole),
    }
    found = literals(script)
    assert {name: found[name] for name in expected} == expected


def test_shapers_are_the_tunings_to_the_last_bit(script, tuning):
    expected = {
        number: {
            "x": list(known.region.x),
            "y": list(known.region.y),
            "pretension": list(known.region.pretension),
            "times": known.shaper.times.tolist(),
            "amplitudes": known.shaper.amplitudes.tolist(),
        }
        for number, known in enumerate(tuning.shapers, 1)
    }
    assert vectors(script) == expected


def test_its_loop_is_the_one_whose_margins_are_told(script, tuning):
    found = systems(script)
    period = float(tuning.controller.period)
    plant = control.sample_system(found["plant"], period, method="zoh")
    loop = found["computing"] * found["controller"] * plant
    frequencies = np.geomspace(1.0, 0.9 * np.pi / period, 30)
    respond = jax.jit(
        jax.vmap(lambda w: sampled_loop(describe(tuning).plant, tuning.controller, w))
    )
    expected = np.asarray(respond(jnp.asarray(frequencies)))
    # python-control's sampled plant has a numerator of g h^2 / 2 (z + 1), summed up from terms
    # of 1, and a denominator that cancels to (w h)^2 where z is near 1.
    z = np.exp(1j * frequencies * period)
    numerator = found["plant"].num[0][0][-1] * period**2 / 2 * np.abs(z + 1)
    tolerance = 16 * np.finfo(float).eps * (1 / numerator + (frequencies * period) ** -2)
    error = np.abs(loop(z) / expected - 1)
    assert np.all(error <= tolerance)


shape = jax.jit(lambda shaper, samples, period: shape_samples(shaper, samples, period=period))


def test_its_sum_over_interp1_shapes_as_shape_samples_does(script, tuning):
    steps = np.random.default_rng(4).normal(0, 1e-3, 900)
    reference, period = np.cumsum(steps), literals(script)["period"]
    instants = np.arange(reference.size)
    for number, known in enumerate(tuning.shapers, 1):
        impulses = vectors(script)[number]
        # The script's loop, with numpy's interp for interp1.
        shaped = sum(
            amplitude * np.interp(np.maximum(instants - time / period, 0), instants, reference)
            for time, amplitude in zip(impulses["times"], impulses["amplitudes"], strict=True)
        )
        expected = shape(known.shaper, jnp.asarray(reference), tuning.controller.period)
        assert np.max(np.abs(shaped - np.asarray(expected))) <= 1e-12


@pytest.mark.skipif(OCTAVE is None, reason="GNU Octave isn't here")
def test_octave_runs_it_and_its_drive_arrives(script, tmp_path):
    probe = "has = !isempty(pkg('list', 'control')); printf('%d', has);"
    known = subprocess.run([OCTAVE, "--eval", probe], capture_output=True, text=True)
    if known.stdout.strip() != "1":
        pytest.skip("Octave's package control isn't here")
    (tmp_path / FILE).write_text(script)
    ask = (
        "set(0, 'defaultfigurevisible', 'off'); scdpr_controller; "
        "printf('\\nanswer %.17g %.17g\\n', angle(end), angle_reference(end));"
    )
    done = subprocess.run(
        [OCTAVE, "--eval", ask], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    reached, wanted = (float(cell) for cell in done.stdout.split("answer")[1].split()[:2])
    # A second after the last impulse, at a bandwidth of some 40 rad/s.
    assert abs(reached / wanted - 1) <= 1e-3
