"""Does the paper's model give the paper's results? A walk through it, also a plain script."""

import marimo

app = marimo.App(width="medium")


@app.cell
def _():
    import jax
    import marimo as mo
    import numpy as np

    # Before anything is computed: the library itself never changes a setting.
    jax.config.update("jax_enable_x64", True)
    return mo, np


@app.cell
def _(mo):
    mo.md(
        """
        # Does the paper's model give the paper's results?

        "Dynamic Model of a Novel Planar Cable Driven Parallel Robot with a Single Cable Loop"
        (Actuators 2023) prints a robot, a model of it, and what the robot did. Here the model
        is asked for what the robot did. All of it at once: `scdpr reproduce`.
        """
    )
    return


@app.cell
def _(mo):
    from experiments.paper.contradictions import CONTRADICTIONS

    lines = [
        f"| {one.sum} | {one.comes_to:.4g} | {one.number:.4g} {one.unit} | {one.printed} |"
        for one in CONTRADICTIONS
    ]
    mo.md(
        "## First, a pocket calculator\n\nThe paper contradicts itself in places that "
        "need no model.\n\n| compute | it comes to | printed | which is |\n"
        "| --- | --- | --- | --- |\n" + "\n".join(lines)
    )
    return


@app.cell
def _(mo):
    from experiments.paper.topics.prototype.numbers import (
        derived_as_printed,
        derived_consistently,
    )

    printed, used = derived_as_printed(), derived_consistently()
    mo.md(
        f"""
        ## What a millimetre does

        Table 1 prints a pulley radius of 7.3 mm. The drives' inertia then weighs
        {printed.reflected_inertia:.0f} kg at the cable, and 10 V move it at
        {printed.top_speed:.2f} m/s. With 73 mm it is {used.reflected_inertia:.1f} kg and
        {used.top_speed:.2f} m/s, and the diagonal manoeuvre asks for
        {used.diagonal_voltage:.1f} V: "near the saturation limit", as the paper says.
        """
    )
    return


@app.cell
def _(mo, np):
    from experiments.paper.topics.knocks.numbers import MEASURED, effective_share, level
    from scdpr_jax.linear.modes import BOTH_HELD, DRIVEN, LOWER_HELD, PRINTED

    conditions = {
        "(18) as printed": PRINTED,
        "lower carriage with the drives": DRIVEN,
        "lower carriage held": LOWER_HELD,
        "both held by friction": BOTH_HELD,
    }
    table = "\n".join(
        f"| {name} | {level(c).nominal(200.0):.2f} | {level(c).nominal(500.0):.2f} | "
        f"{np.mean([level(c).share(s) for s in MEASURED]):.2f} | {level(c).rise:.2f} |"
        for name, c in conditions.items()
    )
    mo.md(
        f"""
        ## Which tension rings at 2.4 and 3.9 Hz?

        None of the nominal ones. What holds the carriages decides how much of it acts:

        | carriages | 200 N [Hz] | 500 N [Hz] | T_eff/T for 2.4 and 3.9 Hz | middle over ends |
        | --- | --- | --- | --- | --- |
        {table}

        The frequency is reported to be highest at mid-height, so the last column should
        exceed one. The default robot has T_eff/T = {effective_share():.3f}.
        """.replace("\n        ", "\n")
    )
    return


@app.cell
def _(mo, np):
    from experiments.paper.topics.manoeuvres.figure import draw_errors
    from experiments.paper.topics.manoeuvres.section import errors

    runs = errors()
    told = "\n".join(
        f"- {name}: {1e3 * run.error.max():.1f} mm (reported: about {1e3 * reported:.0f}), "
        f"rotation {np.rad2deg(run.tilt):.1f}°"
        for name, (run, reported) in runs.items()
    )
    mo.vstack(
        [
            mo.md(
                "## Does the closed loop err as reported?\n\nAt half of Table 3's time a leg, "
                f"and in the vertical with the weight that the paper leaves out:\n\n{told}"
            ),
            draw_errors(runs),
        ]
    )
    return


@app.cell
def _(mo):
    from collections import Counter

    from experiments.paper.catalogue import CLAIMS

    counted = Counter(claim.verdict.value for claim in CLAIMS)
    verdicts = "\n".join(f"- {count} {verdict}" for verdict, count in counted.items())
    mo.md(
        f"""
## What surprised

Of {len(CLAIMS)} claims:

{verdicts}

A fifth to a quarter of the nominal pretension explains frequencies, tracking error and
rotation at once, though they were measured in different experiments. Why it is that part
nobody can tell from the paper; nor why the frequency should be highest at mid-height, as with
carriages free of the drives, while in the closed loop the drives' inertia is there to see.
        """
    )
    return


if __name__ == "__main__":
    app.run()
