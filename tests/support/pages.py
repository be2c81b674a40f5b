"""What the README and the documentation's pages have in them: blocks, commands, links."""

import importlib.util
import pathlib
import re
from typing import NamedTuple

ROOT = pathlib.Path(__file__).parents[2]
README = "README.md"
PAGES = (
    README,
    "CONTRIBUTING.md",
    "CHANGELOG.md",
    *sorted(str(path.relative_to(ROOT)) for path in (ROOT / "docs").glob("*.md")),
)
"""All pages, from the project's folder."""

_FENCED = re.compile(r"^( *)```(\w*)\n(.*?)^\1```$", re.MULTILINE | re.DOTALL)
_LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
_CODE = re.compile(r"(?<!`)`([^`]+)`(?!`)")


class Block(NamedTuple):
    """Code of a page."""

    line: int
    """Where it begins."""
    text: str
    """The code."""


def text_of(page):
    return (ROOT / page).read_text(encoding="utf-8")


def python_blocks(page):
    """Python of a page, in order."""
    text = text_of(page)
    return [
        Block(text[: found.start()].count("\n") + 2, found[3])
        for found in _FENCED.finditer(text)
        if found[2] == "python"
    ]


def command_lines(page):
    """Lines that a reader is to type: indented ones that begin with the command's name."""
    return [
        line.strip() for line in text_of(page).splitlines() if re.match(r"(    )+scdpr ", line)
    ]


def mentioned_commands(page):
    """Commands within a sentence or a table, which needn't be whole."""
    prose = _FENCED.sub("", text_of(page))
    return [" ".join(own.split()) for own in _CODE.findall(prose) if own.startswith("scdpr ")]


def links(page):
    """Targets in this project: a path from the page, and an anchor, each may be empty."""
    prose = _CODE.sub("", _FENCED.sub("", text_of(page)))
    targets = [own for own in _LINK.findall(prose) if "://" not in own]
    return [tuple((own + "#").split("#")[:2]) for own in targets]


def anchors(page):
    """A page's anchors, as both GitHub and the site make them of headings."""
    headings = re.findall(r"^#+ (.+)$", _FENCED.sub("", text_of(page)), re.MULTILINE)
    plain = (re.sub(r"[^\w\- ]", "", own.lower()) for own in headings)
    return {own.strip().replace(" ", "-") for own in plain}


def script_of(name):
    """A script of the documentation, as a module."""
    spec = importlib.util.spec_from_file_location(name, ROOT / f"docs/{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
