"""What `scdpr_jax` shows, and what importing it does."""

import json
import subprocess
import sys
import types

import pytest

import scdpr_jax

IMPORT_ALL = """
import importlib, json, pkgutil, sys
import jax
before = dict(jax.config.values)
import scdpr_jax
for module in pkgutil.walk_packages(scdpr_jax.__path__, "scdpr_jax."):
    importlib.import_module(module.name)
after = dict(jax.config.values)
changed = [name for name in after if after[name] != before.get(name)]
edges = [name for name in ("pint", "matplotlib", "rich", "scipy.io") if name in sys.modules]
print(json.dumps({"changed": changed, "edges": edges}))
"""


@pytest.fixture(scope="module")
def fresh_import():
    ran = subprocess.run(
        [sys.executable, "-W", "error", "-c", IMPORT_ALL], capture_output=True, text=True
    )
    assert ran.returncode == 0, ran.stderr
    return json.loads(ran.stdout)


def test_importing_changes_no_jax_configuration(fresh_import):
    assert fresh_import["changed"] == []


def test_importing_brings_in_no_package_of_the_edges(fresh_import):
    assert fresh_import["edges"] == []


def test_dir_shows_what_a_user_calls():
    assert {"simulate", "natural_frequencies", "linearise", "static_workspace"} <= set(
        dir(scdpr_jax)
    )


def test_dir_shows_no_wing():
    shown = [getattr(scdpr_jax, name) for name in dir(scdpr_jax)]
    assert not any(isinstance(value, types.ModuleType) for value in shown)


@pytest.mark.parametrize("name", dir(scdpr_jax))
def test_whatever_is_shown_says_what_it_is(name):
    value = getattr(scdpr_jax, name)
    if callable(value):
        assert value.__doc__
