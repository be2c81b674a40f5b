"""The pages of the API, made from docstrings: one for each package, a section for each wing.

Docstrings of this project are Markdown with formulas between dollars, and Google's sections. So
they are put into MyST's directives as they are, which no reader of reStructuredText could do.
"""

import ast
import importlib
import inspect
import itertools
import pathlib
import re
import sys
import textwrap
from collections.abc import Iterator
from types import ModuleType

PACKAGES = {
    "scdpr_jax": "The robot: parameters, engines, linear model, commands.",
    "identification": "Logged runs to parameters with their uncertainty.",
    "tuning": "Parameters and frequencies to gains, shapers and planned legs.",
}
"""The packages that a program calls; what `experiments` has is the command line."""
_SECTIONS = ("Args", "Returns", "Yields", "Raises")
_TITLES = {"Args": "Arguments"}
_ENTRY = re.compile(r"(\*{0,2}\w+): (.*)", re.DOTALL)


def write_pages(folder: pathlib.Path) -> None:
    """Write a page for each package.

    Args:
        folder: Where they are to be; made where there is none.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for package, purpose in PACKAGES.items():
        text = "\n".join(_page(importlib.import_module(package), purpose))
        path = folder / f"{package}.md"
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def _page(package: ModuleType, purpose: str) -> Iterator[str]:
    """A package's names, by the wing that they stand in."""
    yield f"# {package.__name__}\n\n{purpose}\n\n:::{{py:module}} {package.__name__}\n:::\n"
    wings: dict[str, list[str]] = {}
    for name in dir(package):
        thing = getattr(package, name)
        if not name.startswith("_"):
            home = _home(package, name, thing)
            wings.setdefault(_wing(home), []).append(_entry(package, home, name, thing))
    for wing, entries in sorted(wings.items()):
        about = _summary(importlib.import_module(f"{package.__name__}.{wing}"))
        yield f"## {wing}\n\n{about}\n"
        yield from entries


def _home(package: ModuleType, name: str, thing: object) -> ModuleType:
    """The module that defines a name."""
    own = getattr(thing, "__module__", None)
    if callable(thing) and isinstance(own, str) and own.startswith(package.__name__):
        return sys.modules[own]
    inside = f"{package.__name__}."
    return next(
        module
        for path, module in sorted(sys.modules.items())
        if path.startswith(inside) and name in _documented(module)
    )


def _wing(module: ModuleType) -> str:
    return module.__name__.split(".")[1]


def _summary(thing: object) -> str:
    return (inspect.getdoc(thing) or "").split("\n\n")[0]


def _documented(module: ModuleType) -> dict[str, str]:
    """A module's or a class's names, with the text below each."""
    tree = ast.parse(textwrap.dedent(inspect.getsource(module)))
    body = tree.body[0].body if isinstance(tree.body[0], ast.ClassDef) else tree.body
    return dict(_texts(body))


def _texts(body: list[ast.stmt]) -> Iterator[tuple[str, str]]:
    for statement, below in itertools.pairwise(body):
        targets = getattr(statement, "targets", [getattr(statement, "target", None)])
        text = getattr(getattr(below, "value", None), "value", None)
        if isinstance(targets[0], ast.Name) and isinstance(below, ast.Expr):
            yield targets[0].id, inspect.cleandoc(str(text))


def _entry(package: ModuleType, home: ModuleType, name: str, thing: object) -> str:
    """A name with what its docstring says."""
    if inspect.isclass(thing):
        return _directive("class", package, name, _class_body(thing), depth=5)
    if callable(thing):
        return _function(package, name, thing)
    return _directive("data", package, name, _documented(home).get(name, ""), depth=4)


def _function(package: ModuleType, name: str, thing: object) -> str:
    """A function; one that is compiled has the signature of what was compiled."""
    call = f"{name}({_arguments(inspect.unwrap(thing))})"
    return _directive("function", package, call, _markdown(inspect.getdoc(thing)), depth=4)


def _class_body(own: type) -> str:
    """A class: its purpose, fields and methods."""
    parts = [_markdown(inspect.getdoc(own))]
    parts += [
        f":::{{py:attribute}} {name}\n:no-index:\n\n{text}\n:::\n"
        for name, text in _documented(own).items()
        if not name.startswith("_")
    ]
    for name, thing in vars(own).items():
        text = getattr(thing, "__doc__", None)
        if name.startswith("_") or not text or not callable(thing):
            continue
        call = f"{name}({_arguments(thing)})"
        body = _markdown(inspect.cleandoc(text))
        parts.append(f":::{{py:method}} {call}\n:no-index:\n\n{body}\n:::\n")
    return "\n".join(parts)


def _arguments(thing: object) -> str:
    """Names of arguments, with defaults that are short; types are in the text."""
    shown = []
    for parameter in inspect.signature(thing).parameters.values():
        if parameter.name == "self":
            continue
        default = parameter.default
        if default is not inspect.Parameter.empty and len(repr(default)) > 24:
            default = _Short()
        shown.append(parameter.replace(annotation=inspect.Parameter.empty, default=default))
    return str(inspect.Signature(shown))[1:-1]


class _Short:
    """A default that is too long to be told."""

    def __repr__(self) -> str:
        return "..."


def _directive(kind: str, package: ModuleType, call: str, body: str, *, depth: int) -> str:
    fence = ":" * depth
    return f"{fence}{{py:{kind}}} {call}\n:module: {package.__name__}\n\n{body}\n{fence}\n"


def _markdown(docstring: str | None) -> str:
    """A docstring with its sections as lists."""
    parts = re.split(rf"^({'|'.join(_SECTIONS)}):\n", docstring or "", flags=re.MULTILINE)
    text = [parts[0].strip()]
    for title, body in zip(parts[1::2], parts[2::2], strict=True):
        text.append(f"**{_TITLES.get(title, title)}**")
        text.append("\n".join(_items(textwrap.dedent(body), title)))
    return "\n\n".join(text)


def _items(body: str, title: str) -> Iterator[str]:
    """A section's entries; what a function returns is one."""
    lines = re.split(r"\n(?=\S)", body.strip()) if title in ("Args", "Raises") else [body]
    for line in lines:
        words = " ".join(line.split())
        entry = _ENTRY.fullmatch(words)
        if entry and title in ("Args", "Raises"):
            yield f"- `{entry[1]}`: {entry[2]}"
        else:
            yield words
