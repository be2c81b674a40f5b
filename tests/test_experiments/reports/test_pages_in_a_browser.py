"""What a reader sees of the pages: on a phone, a desk, on paper, by night."""

import contextlib
import dataclasses
import importlib.resources
import re
import signal
import subprocess
import sys

import numpy as np
import pytest
from browser import browser, executable
from report_samples import TRUTH, campaign, estimate, frequencies, parameter, tuning
from shown_results import write_results

from experiments.reports.report import write_report
from experiments.studies.findings.findings import findings
from scdpr_jax.robot.quantities import EVERY_QUANTITY, quantity

pytestmark = pytest.mark.skipif(
    executable() is None, reason="there is no Chromium to look at pages with"
)

SMALL = """(() => {
  const small = [], walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walk.nextNode()) {
    const own = walk.currentNode.parentElement, box = own.getBoundingClientRect();
    if (!walk.currentNode.data.trim() || !box.width || own.closest("style, script")) continue;
    let size = parseFloat(getComputedStyle(own).fontSize);
    if (own instanceof SVGElement) {
      const matrix = own.getScreenCTM();
      size *= Math.hypot(matrix.a, matrix.b);
    }
    if (size < 9) small.push([walk.currentNode.data.trim().slice(0, 30), size]);
  }
  return small;
})()"""
"""Texts whose letters are lower than 9 px."""

CUT = """(() => {
  const width = document.documentElement.clientWidth;
  return [...document.querySelectorAll("main *")].filter((own) => {
    const box = own.getBoundingClientRect();
    const hidden = box.width <= 1 || own.closest("svg svg") || own.closest("svg") !== null
      && own.tagName !== "svg";
    return !hidden && (box.right > width + 0.5 || box.left < -0.5);
  }).map((own) => own.outerHTML.slice(0, 80));
})()"""
"""Parts of a page that go beyond its edges."""

UNNAMED = """[...document.querySelectorAll("svg, img, input, select")].filter((own) =>
  !own.closest("[aria-hidden], [role=img][aria-label]") && !own.ariaLabel
  && !(own.labels && own.labels.length)).map((own) => own.outerHTML.slice(0, 80))"""
"""Pictures and controls that nobody tells the name of."""

CONTRAST = """(() => {
  const parts = (colour) => colour.match(/[\\d.]+/g).map(Number);
  const light = (colour) => parts(colour).slice(0, 3).map((c) => c / 255).map((c) =>
    c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4)
    .reduce((sum, c, k) => sum + c * [0.2126, 0.7152, 0.0722][k], 0);
  const ground = (own) => {
    const colour = getComputedStyle(own).backgroundColor, alpha = parts(colour)[3] ?? 1;
    if (alpha > 0) return colour;
    return own.parentElement ? ground(own.parentElement) : "rgb(255, 255, 255)";
  };
  const faint = [], walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walk.nextNode()) {
    const own = walk.currentNode.parentElement;
    if (!walk.currentNode.data.trim() || own.closest("style, script, noscript")) continue;
    const shown = getComputedStyle(own);
    const ink = own instanceof SVGElement ? shown.fill : shown.color;
    const [low, high] = [light(ink), light(ground(own))].sort((a, b) => a - b);
    const contrast = (high + 0.05) / (low + 0.05);
    if (contrast < 4.5) faint.push([walk.currentNode.data.trim().slice(0, 30), contrast]);
  }
  return faint;
})()"""
"""Words whose contrast to their ground is below WCAG's 4.5."""


AXE = importlib.resources.files("axe_core_python").joinpath("axe.min.js").read_text("utf-8")
"""Rules of WCAG and of good practice, as others check them."""

RULES = """axe.run({exclude: [["svg > *"]]}, {resultTypes: ["violations"]}).then((found) =>
  found.violations.map((own) => [own.id, ...own.nodes.map((node) => node.html)]))"""
"""What they find. A picture is one thing with a name to it, and has thousands of parts."""


def broken_rules(page):
    """What axe finds on a page as it is shown."""
    page.ask("document.querySelectorAll('details').forEach((own) => (own.open = true))")
    page.ask(f"{AXE}; 0")
    return page.ask(RULES)


@pytest.fixture(scope="module")
def page():
    with browser() as opened:
        yield opened


def twelve():
    """An estimate of twelve quantities, every pair of which is correlated."""
    parameters = tuple(
        parameter(kind.name, 0.0131, 1e-6, unit=kind.unit, setting=setting)
        for kind, setting in (
            *((kind, None) for kind in EVERY_QUANTITY[-10:]),
            *((quantity("effective_pretension"), f"{tension} N") for tension in (350, 500)),
        )
    )
    made = estimate(parameters=parameters)
    matrix = np.full((12, 12), -0.95) + 1.95 * np.eye(12)
    return dataclasses.replace(
        made, fitted=dataclasses.replace(made.fitted, correlation=matrix)
    )


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    path = tmp_path_factory.mktemp("report") / "report.html"
    found = findings(twelve(), campaign=campaign(), frequencies=frequencies(), tuning=tuning())
    write_report(path, found, title="Calibration", truth=TRUTH)
    return path.as_uri()


@contextlib.contextmanager
def shown(folder):
    """The address that `scdpr show` tells; Ctrl-C ends it with one line."""
    process = subprocess.Popen(
        [sys.executable, "-m", "experiments.cli", "show", str(folder)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    with process:
        try:
            yield re.search(r"http://\S+/", process.stdout.readline())[0]
        finally:
            process.send_signal(signal.SIGINT)
            told = process.communicate(timeout=20)
    assert process.returncode == 130
    assert len("".join(told).splitlines()) == 1


def look(page):
    """What is wrong with a page as it is shown."""
    page.ask("document.querySelectorAll('details').forEach((own) => (own.open = true))")
    return page.ask(CUT) + page.ask(UNNAMED) + page.ask(CONTRAST) + page.complaints


@pytest.mark.parametrize("dark", [False, True])
@pytest.mark.parametrize("width", [360, 800, 1200])
def test_nothing_of_a_report_is_cut_unnamed_or_faint(page, report, width, dark):
    page.show(report, width=width, dark=dark)
    assert look(page) == []
    assert page.ask("document.documentElement.scrollWidth") == width


@pytest.mark.parametrize("dark", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_a_report_breaks_no_rule_of_accessibility(page, report, dark):
    page.show(report, width=1200, dark=dark)
    assert broken_rules(page) == []


def test_a_page_that_breaks_rules_of_accessibility_is_found_out(page, tmp_path):
    bad = tmp_path / "bad.html"
    bad.write_text('<html><p style="color: #999">faint</p><img src="x.png"><input></html>')
    page.show(bad.as_uri(), width=1200)
    names = {name for name, *_ in broken_rules(page)}
    assert names >= {"color-contrast", "image-alt", "label", "html-has-lang", "document-title"}


def test_what_is_looked_for_is_found_where_it_is(page, tmp_path):
    bad = tmp_path / "bad.html"
    bad.write_text(
        '<main><p style="width: 500px; background: #eee; color: #999">faint, and cut</p>'
        '<svg width="9" height="9"></svg><p style="font-size: 8px">small</p></main>'
    )
    page.show(bad.as_uri(), width=360)
    assert len(page.ask(CUT)) == len(page.ask(UNNAMED)) == len(page.ask(CONTRAST)) == 1
    assert page.ask(SMALL) == [["small", 8]]


def test_nothing_of_a_report_is_cut_on_paper(page, report):
    # A4 within its margins, at 96 px an inch.
    page.show(report, width=688, paper=True)
    assert look(page) == []
    assert page.ask("getComputedStyle(document.querySelector('.strip')).display") == "grid"
    assert page.ask("getComputedStyle(document.querySelector('.film')).display") == "none"


def test_no_letter_of_a_report_is_lower_than_9_px_on_a_phone(page, report):
    page.show(report, width=360)
    page.ask("document.querySelectorAll('details').forEach((own) => (own.open = true))")
    assert page.ask(SMALL) == []


def test_the_three_answers_stand_on_the_first_screen_of_a_desk(page, report):
    page.show(report, width=1200, height=700)
    bottoms = page.ask(
        "[...document.querySelectorAll('.answer')].map((o) => o.getBoundingClientRect().bottom)"
    )
    assert len(bottoms) == 3
    assert max(bottoms) <= 700


PLACE = "document.getElementById('film-run-body').getBoundingClientRect().left"


def test_the_robot_stands_still_until_it_is_started(page, report):
    pause = "new Promise((done) => setTimeout(done, 300))"
    page.show(report, width=1200)
    first = page.ask(PLACE)
    page.ask(pause)
    assert page.ask(PLACE) == first
    page.ask("document.getElementById('film-run-run').click()")
    page.ask(pause)
    assert page.ask(PLACE) != first


def test_who_wants_no_motion_gets_poses(page, report):
    page.show(report, width=1200, still=True)
    assert page.ask("getComputedStyle(document.querySelector('.film')).display") == "none"
    assert page.ask("document.querySelector('.strip svg').getBoundingClientRect().width") > 100


@pytest.mark.slow
def test_a_leg_is_planned_while_a_slider_moves(page, tmp_path):
    ready = "document.querySelector('#planned table') && !planned.hasAttribute('aria-busy')"
    move = (
        "(() => { const s = document.getElementById('slider-to_x'); s.value = 1.2;"
        "s.dispatchEvent(new Event('input', {bubbles: true})); })()"
    )
    with shown(write_results(tmp_path)) as address:
        page.show(f"{address}runs?run=0002-manoeuvre", width=360)
        assert look(page) == broken_rules(page) == []
        page.show(f"{address}plan", width=360)
        page.wait(ready, seconds=60)
        before = page.ask("planned.innerText")
        page.ask(move)
        page.wait(f"{ready} && planned.innerText !== {before!r}")
        assert "to_x=1.2" in page.ask("document.querySelector('[href^=\"/plan.csv\"]').href")
        assert page.ask("location.search").endswith("time=2")
        assert look(page) == broken_rules(page) == []
        assert page.ask(SMALL) == []
