"""The API's pages are made from docstrings."""

import json
import re
import subprocess
import sys

import pages
import pytest

PACKAGES = ("scdpr_jax", "identification", "tuning")
# In a process of its own: checks of shapes make importing everything take long.
WRITE = """
import importlib, json, pathlib, sys
sys.path.insert(0, "docs")
import api_pages
api_pages.write_pages(pathlib.Path(sys.argv[1]))
print(json.dumps({name: dir(importlib.import_module(name)) for name in api_pages.PACKAGES}))
"""


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """The pages, and the public names of each package."""
    folder = tmp_path_factory.mktemp("api")
    call = [sys.executable, "-c", WRITE, str(folder)]
    done = subprocess.run(call, check=True, cwd=pages.ROOT, stdout=subprocess.PIPE)
    texts = {path.stem: path.read_text(encoding="utf-8") for path in folder.glob("*.md")}
    return texts, json.loads(done.stdout)


@pytest.mark.parametrize("package", PACKAGES)
def test_every_public_name_has_its_entry(package, written):
    texts, names = written
    told = re.findall(r"^:+\{py:(?:class|function|data)\} (\w+)", texts[package], re.MULTILINE)
    assert sorted(told) == sorted(names[package])


def test_a_function_is_told_with_its_arguments_and_what_it_returns(written):
    entry = written[0]["tuning"].split("{py:function} plan_leg(")[1].split("\n::::\n")[0]
    assert entry.startswith("robot, controller, start, end, *, leg_time=None")
    assert "- `robot`: " in entry
    assert "**Returns**" in entry


def test_a_field_is_told_with_its_unit(written):
    entry = written[0]["scdpr_jax"].split("{py:class} Carriage\n")[1].split("\n:::::\n")[0]
    assert re.search(r"\{py:attribute\} mass\n.*?\[kg\]", entry, re.DOTALL)
