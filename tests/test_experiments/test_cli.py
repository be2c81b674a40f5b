import os
import pathlib
import subprocess
import sys

import pytest

import experiments
from experiments.cli import VERBS, main
from experiments.verbs.exit_status import BAD_INPUT, DONE

README = (pathlib.Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")
EVERY_VERB = tuple(verb for wing in VERBS.values() for verb in wing)
every_verb = pytest.mark.parametrize("verb", EVERY_VERB)


@every_verb
def test_every_verb_tells_its_arguments(verb, capsys):
    with pytest.raises(SystemExit) as end:
        main([verb, "--help"])
    assert end.value.code in (0, None)
    assert f"usage: scdpr {verb}" in capsys.readouterr().out


@every_verb
def test_the_readme_says_what_every_verb_writes(verb):
    assert f"| `scdpr {verb}" in README


def test_every_module_of_a_verb_is_a_verb():
    folder = pathlib.Path(experiments.__file__).parent / "verbs"
    modules = {path.stem.rstrip("_").replace("_", "-") for path in folder.glob("*/[a-z]*.py")}
    assert modules == set(EVERY_VERB)


def test_the_help_names_every_verb(capsys):
    assert main(["--help"]) == DONE
    told = capsys.readouterr().out
    assert all(f"\n  {verb} " in told for verb in EVERY_VERB)


def test_of_a_misspelt_verb_the_nearest_is_told(capsys):
    assert main(["calibrat"]) == BAD_INPUT
    assert "Did you mean `scdpr calibrate`?" in capsys.readouterr().err


WITHOUT_JAX = """
import sys
from experiments.cli import main
try:
    main(sys.argv[1:])
except SystemExit:
    pass
assert "jax" not in sys.modules, "jax was imported"
"""


@every_verb
def test_help_waits_for_no_jax(verb):
    subprocess.run([sys.executable, "-c", WITHOUT_JAX, verb, "--help"], check=True)


@pytest.mark.parametrize("verb", ["calibrate", "identify", "frequencies"])
def test_what_is_wrong_with_a_campaign_is_said_before_jax_is_loaded(verb, tmp_path):
    (tmp_path / "campaign").mkdir()
    call = [verb, str(tmp_path / "campaign"), "--out", str(tmp_path / "out")]
    subprocess.run([sys.executable, "-c", WITHOUT_JAX, *call], check=True)


def test_numpy_sums_alike_on_any_number_of_cores():
    script = """
import os, sys
from experiments import cli
assert "numpy" not in sys.modules
cli.main(["--version"])
assert os.environ["OPENBLAS_NUM_THREADS"] == "1"
"""
    clean = {k: v for k, v in os.environ.items() if not k.endswith("_NUM_THREADS")}
    subprocess.run([sys.executable, "-c", script], check=True, env=clean)
