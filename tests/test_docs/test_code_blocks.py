"""What the README and the documentation tell a reader to type."""

import functools
import importlib
import inspect
import json
import keyword
import os
import pathlib
import shlex
import subprocess
import sys

import pages
import pytest
import tyro

from experiments.cli import VERBS
from experiments.verbs.help_text import check_options, described

WINGS = {verb: wing for wing, verbs in VERBS.items() for verb in verbs}
WITH_PYTHON = tuple(page for page in pages.PAGES if pages.python_blocks(page))
TYPED = [(page, line) for page in pages.PAGES for line in pages.command_lines(page)]
MENTIONED = [
    (page, line)
    for page in pages.PAGES
    if page != "CHANGELOG.md"
    for line in pages.mentioned_commands(page)
]
ENOUGH_TO_BE_MEANT = 20
"""Lines that are to be typed: fewer would mean that they aren't found."""


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """What went wrong in each page's Python, run in a process as a reader's."""
    folder = tmp_path_factory.mktemp("pages")
    script = pathlib.Path(pages.__file__).with_name("page_runs.py")
    call = [sys.executable, str(script), str(folder), *WITH_PYTHON]
    subprocess.run(call, check=True, env={**os.environ, "MPLBACKEND": "agg"})
    return json.loads((folder / "told.json").read_text())


@pytest.mark.parametrize("page", WITH_PYTHON)
def test_the_python_of_a_page_runs(page, runs):
    assert runs[page] == ""


def test_pages_with_python_and_with_commands_are_found():
    assert {"README.md", "docs/get-started.md"} <= set(WITH_PYTHON)
    assert len(TYPED) >= ENOUGH_TO_BE_MEANT


def verb_of(words):
    name = words[1].replace("-", "_") + "_" * keyword.iskeyword(words[1])
    module = importlib.import_module(f"experiments.verbs.{WINGS[words[1]]}.{name}")
    return getattr(module, name)


def parse(words):
    """Read a command line as the verb would, without doing what it does."""
    verb = verb_of(words)

    @functools.wraps(verb)
    def idle(*args, **kwargs):
        return 0

    del idle.__wrapped__
    idle.__signature__ = inspect.signature(verb)
    check_options(verb, words[2:])
    return tyro.cli(described(idle), args=words[2:], prog=f"scdpr {words[1]}")


@pytest.mark.parametrize(("page", "line"), TYPED)
def test_a_command_of_a_page_is_one_that_its_verb_takes(page, line, capsys):
    try:
        assert parse(shlex.split(line, comments=True)) == 0
    except SystemExit:
        pytest.fail(f"{page}: {line}\n{capsys.readouterr()}")


def test_a_command_with_an_option_that_its_verb_lacks_is_refused(capsys):
    with pytest.raises((SystemExit, ValueError)):
        parse(["scdpr", "check", "CAMPAIGN", "--nonsense"])
    with pytest.raises(SystemExit):
        parse(["scdpr", "calibrate", "CAMPAIGN"])
    assert "--out" in capsys.readouterr().err


@pytest.mark.parametrize(("page", "line"), MENTIONED)
def test_what_is_mentioned_of_a_verb_exists(page, line):
    words = shlex.split(line.replace("…", "").replace("`", ""))
    if words[1].startswith("-") or words[1].isupper():
        return
    assert words[1] in WINGS, f"{page}: {line}"
    options = set(options_of(verb_of(words))) | {"--help"}
    assert {own.partition("=")[0] for own in words if own.startswith("--")} <= options


def options_of(verb):
    for name, parameter in inspect.signature(verb).parameters.items():
        if parameter.kind is not inspect.Parameter.POSITIONAL_ONLY:
            marks = getattr(parameter.annotation, "__metadata__", ())
            named = [own.name for own in marks if getattr(own, "name", None)]
            option = (named or [name])[0].replace("_", "-")
            yield from (f"--{option}", f"--no-{option}")
