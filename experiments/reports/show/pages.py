"""The pages that show a folder of results."""

import dataclasses
from collections.abc import Callable, Mapping

from experiments.figures.leg_sketch import command_sketch, way_sketch
from experiments.figures.robot_film import Track, robot_film
from experiments.page.number_text import plain
from experiments.page.page import page
from experiments.reports import plan_report
from experiments.reports.show.asked_leg import AskedLeg, asked_leg, sliders
from experiments.reports.show.planned import Planning
from experiments.reports.show.results import REPORT, Results
from tuning.plan.expectation import Expectation
from tuning.plan.planning import Planned

_LEAST = 0.01
"""Length below which nothing is told [mm]."""


@dataclasses.dataclass(frozen=True)
class Link:
    """A place of these pages."""

    address: str
    """Where it is."""
    name: str
    """What it is called."""


def places(results: Results) -> tuple[Link, ...]:
    """The pages that a folder has.

    Args:
        results: The folder.

    Returns:
        Links, in the order in which they are read.
    """
    links = [Link("/", "Overview")]
    if (results.folder / REPORT).is_file():
        links.append(Link("/report", "Report"))
    if results.runs and results.robot is not None:
        links.append(Link("/runs", "Runs"))
    if can_plan(results):
        links.append(Link("/plan", "Plan a leg"))
    return tuple(links)


def can_plan(results: Results) -> bool:
    """Whether legs can be planned: the tuning knows its robot.

    Args:
        results: The folder.

    Returns:
        Whether they can.
    """
    return results.tuning is not None and bool(results.tuning.robots)


def overview(results: Results) -> str:
    """The first page: where to go, and the files to download.

    Args:
        results: The folder.

    Returns:
        HTML.
    """
    files = [
        (name, f"{plain(path.stat().st_size / 1e3, 2)} kB")
        for name, path in results.files.items()
    ]
    return page(
        "show_overview.html.j2",
        title=f"Results in {results.folder.name or results.folder}",
        here="/",
        places=places(results),
        files=files,
    )


def run_page(results: Results, query: Mapping[str, str]) -> str:
    """The robot in a run.

    Args:
        results: The folder, which has runs and a robot.
        query: What stands in the address.

    Returns:
        HTML.

    Raises:
        ValueError: If there is no run of that name.
    """
    names = tuple(results.runs)
    chosen = query.get("run", names[0])
    if chosen not in results.runs:
        raise ValueError(
            f"No run is called {chosen[:60]!r}, expected one of: {', '.join(names)}. "
            "Choose one."
        )
    time, position = results.runs[chosen]
    track = Track(f"simulated in run {chosen}", time, position)
    return page(
        "show_runs.html.j2",
        title=f"Run {chosen}",
        here="/runs",
        places=places(results),
        runs=names,
        chosen=chosen,
        film=robot_film(results.robot, track, name="film"),
    )


def plan_page(results: Results, planning: Planning, query: Mapping[str, str]) -> str:
    """The page on which legs are tried.

    Args:
        results: The folder, which has a tuning with its robots.
        planning: What plans them.
        query: What stands in the address: the sliders' places.

    Returns:
        HTML, the leg of the address planned, or why it can't be.
    """
    tuning = results.tuning
    try:
        # The first one takes seconds: the page comes before it.
        leg = tried(planning, asked_leg(query, tuning)) if query else ""
    except ValueError as reason:
        leg = problem(str(reason))
    shown = [
        dataclasses.replace(slider, value=_within(query.get(slider.name), slider.value))
        for slider in sliders(tuning.robot_at().robot)
    ]
    return page(
        "show_plan.html.j2",
        title="Plan a leg",
        here="/plan",
        places=places(results),
        sliders=shown,
        settings=[f"{fitted.pretension:g}" for fitted in tuning.robots],
        setting=query.get("setting", ""),
        caution=tuning.caution,
        leg=leg,
    )


def tried(planning: Planning, asked: AskedLeg) -> str:
    """What comes of a leg, as a part of a page.

    Args:
        planning: What plans it.
        asked: The leg.

    Returns:
        HTML.

    Raises:
        ValueError: If it is no leg.
    """
    made, robot = planning.plan(asked), planning.robot(asked)
    limit = float(robot.drive.voltage_limit)
    return page(
        "show_leg.html.j2",
        words=_words(made),
        rows=[
            ("vibration, robot as fitted", *_pair(made, lambda one: one.vibration[0])),
            ("vibration, worst robot", *_pair(made, lambda one: one.worst)),
            ("resting error, robot as fitted", *_pair(made, lambda one: abs(one.resting[0]))),
        ],
        way=way_sketch(robot, made.plan),
        commands=command_sketch(made.plan, limit=limit),
        limit=f"{limit:g}",
        seconds=plain(float(made.plan.time[-1]), 3),
        address=asked.address,
    )


def leg_page(results: Results, planning: Planning, query: Mapping[str, str]) -> str:
    """A leg's own page, as `scdpr plan` writes it.

    Args:
        results: The folder, which has a tuning with its robots.
        planning: What plans it.
        query: What stands in the address.

    Returns:
        HTML.

    Raises:
        ValueError: If it is no leg.
    """
    asked = asked_leg(query, results.tuning)
    robot = planning.robot(asked)
    return plan_report.plan_page(
        planning.plan(asked),
        planning.compared(asked),
        robot=robot,
        tuning=str(results.folder / "tuning.json"),
        caution=results.tuning.caution,
    )


def problem(text: str) -> str:
    """Why there is nothing to show, as a part of a page.

    Args:
        text: The reason.

    Returns:
        HTML.
    """
    return page("show_problem.html.j2", text=text)


def _words(made: Planned) -> str:
    if made.is_plain:
        return (
            "The plain profile without feed-forward: of the planned motion more vibration is "
            "expected."
        )
    if made.leg.time > made.asked_time:
        return (
            f"It takes {plain(made.leg.time, 3)} s: in the {plain(made.asked_time, 3)} s that "
            "were asked for the drives can't bring everything to rest."
        )
    return "It arrives in the time that was asked for."


def _pair(made: Planned, of: Callable[[Expectation], float]) -> tuple[str, str]:
    """A length of the plain profile and of the plan [mm]."""
    return _mm(float(of(made.plain))), _mm(float(of(made.expected)))


def _mm(length: float) -> str:
    """A length in millimetres, to a hundredth, which no camera sees [m]."""
    return f"{1e3 * length:.2f}" if 1e3 * length >= _LEAST else f"< {_LEAST:g}"


def _within(text: str | None, otherwise: float) -> float:
    try:
        return otherwise if text is None else float(text)
    except ValueError:
        return otherwise
