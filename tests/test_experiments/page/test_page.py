"""A page shows what it is given, and can ask for nothing and run nothing."""

import base64
import hashlib
import html
import re

import jinja2
import pytest

from experiments.page import page as pages


def policy_of(text):
    content = re.search(r'Content-Security-Policy" content="([^"]*)"', text)[1]
    return dict(part.split(" ", 1) for part in html.unescape(content).split("; "))


@pytest.fixture
def shown():
    return pages.page(
        "findings.html.j2",
        title="<script>alert(1)</script> \u202e \x1b[31m [bold]",
        sentences=["a < b"],
        tables=[],
        pictures=[],
        method=[],
        provenance=(("run", "=1+1"),),
    )


def test_a_page_loads_and_runs_nothing_but_its_own(shown):
    policy = policy_of(shown)
    assert policy["default-src"] == "'none'"
    assert policy["img-src"] == "data:"
    assert "unsafe-inline" not in policy["script-src"]
    assert policy["style-src"] == "'unsafe-inline'"


def test_markup_and_marks_of_direction_in_a_text_are_shown_as_text(shown):
    assert "<script>alert" not in shown
    assert "&lt;script&gt;alert(1)" in shown
    assert not set("\u202e\x1b") & set(shown)


def test_scripts_of_the_templates_are_the_only_ones_that_run():
    own = "let a = 1;"
    loader = jinja2.DictLoader({"a.j2": f"<script>{own}</script>"})
    policy = pages._policy(jinja2.Environment(loader=loader))
    digest = base64.b64encode(hashlib.sha256(own.encode()).digest()).decode()
    assert f"script-src 'sha256-{digest}'" in policy
