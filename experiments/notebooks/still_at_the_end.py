"""How is the robot still when it stops? Plans and what they do; also a plain script."""

import marimo

app = marimo.App(width="medium")


@app.cell
def _():
    import jax
    import marimo as mo
    import numpy as np

    # Before anything is computed: the library itself never changes a setting.
    jax.config.update("jax_enable_x64", True)
    import scdpr_jax as scdpr
    import tuning

    return mo, np, scdpr, tuning


@app.cell
def _(mo):
    file = mo.ui.text(placeholder="path of a tuning.json", label="tuning", full_width=True)
    mo.vstack(
        [
            mo.md(
                """
                # How is the robot still when it stops?

                A leg by the paper's profile leaves millimetres of vibration and rests
                millimetres off. A planned leg ends with both. Name a `tuning.json` of
                `scdpr calibrate` to plan for your own robot; without one it is the prototype.
                """
            ),
            file,
        ]
    )
    return (file,)


@app.cell
def _(file, scdpr, tuning):
    if file.value:
        tuned = tuning.read_tuning(file.value)
        robot, controller = tuned.robot_at().robot, tuned.controller
    else:
        robot, controller = scdpr.exact(scdpr.consistent()), scdpr.published_pd()
    return controller, robot


@app.cell
def _(mo):
    begin = mo.ui.slider(0.3, 1.9, 0.1, value=0.5, label="from x [m]")
    end = mo.ui.slider(0.3, 1.9, 0.1, value=1.5, label="to x [m]")
    up = mo.ui.slider(0.25, 0.85, 0.05, value=0.7, label="to y [m]")
    seconds = mo.ui.slider(1.5, 4.0, 0.1, value=2.2, label="in [s]")
    mo.vstack([mo.hstack([begin, end]), mo.hstack([up, seconds])])
    return begin, end, seconds, up


@app.cell
def _(begin, controller, end, mo, robot, seconds, tuning, up):
    mo.stop(begin.value == end.value, mo.md("Move one of the ends: there is no leg to plan."))
    planned = tuning.plan_leg(
        robot, controller, (begin.value, 0.5), (end.value, up.value), leg_time=seconds.value
    )
    return (planned,)


@app.cell
def _(mo, planned):
    def shown(own):
        vibration, rest = 1e3 * own.vibration, 1e3 * abs(own.resting)
        return f"{vibration[0]:.2f} | {vibration.max():.2f} | {rest[0]:.2f} | {rest.max():.2f}"

    longer = planned.leg.time > planned.asked_time + 1e-9
    why = ", longer than asked for: the drives can't sooner" if longer else ""
    mo.md(
        f"""
## What is expected of it

| | vibration [mm] | worst robot | resting error [mm] | worst robot |
| --- | --- | --- | --- | --- |
| plain profile | {shown(planned.plain)} |
| planned | {shown(planned.expected)} |

In {planned.plan.time[-1]:.2f} s{why}.
The worst is that of robots with 3 % more and less tension, 20 % more and less friction, and
starts out of line.
"""
    )
    return


@app.cell
def _(controller, mo, np, planned, robot):
    from experiments.figures.robot_film import Track, robot_film
    from experiments.figures.tuning.leg import leg as leg_figure
    from experiments.studies.legs.planned_leg import compare

    compared = compare(robot, controller, planned)
    own, plain = compared.planned[0], compared.plain[0]

    def track(run, name):
        return Track(name, np.asarray(run.time), np.asarray(run.states.position))

    film = robot_film(
        robot, track(own, "as planned"), name="leg", ghost=track(plain, "plain profile")
    )
    figure = leg_figure(
        compared,
        leg_time=planned.leg.time,
        voltage_limit=float(robot.drive.voltage_limit),
    )
    mo.vstack([mo.Html(str(film)), figure])
    return


@app.cell
def _(mo, np, planned):
    moved = planned.plan.position[:, 0]
    back = float(np.sum(np.diff(moved) * np.sign(moved[-1] - moved[0]) < 0)) / moved.size
    mo.md(
        f"""
## What surprised

- The plan is no shaped profile. Friction drags the upper carriage behind and lets it go; a
  constant force while both slide, which one motion of the drives can bring to rest at a single
  moment. For {100 * back:.0f} % of the leg the end-effector goes backwards.
- It has to know the friction, and it is planned for a dozen robots at once: with the fitted
  one alone the vibration of the others is several times as large.
- The feed-forward reaches {np.abs(planned.plan.feedforward).max():.1f} V.
"""
    )
    return


if __name__ == "__main__":
    app.run()
