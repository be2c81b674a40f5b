"""What do my logs tell? From reading them to a verdict on their fit; also a plain script."""

import marimo

app = marimo.App(width="medium")


@app.cell
def _():
    import jax
    import marimo as mo
    import numpy as np

    # Before anything is computed: the library itself never changes a setting.
    jax.config.update("jax_enable_x64", True)
    import identification

    return identification, mo, np


@app.cell
def _(mo):
    folder = mo.ui.text(
        placeholder="path of a campaign's folder", label="campaign", full_width=True
    )
    mo.vstack(
        [
            mo.md(
                """
                # What do my logs tell?

                Name the folder of a campaign in the format of `scdpr check`; `scdpr import`
                makes one of logs of other makes. Without a name this page takes four short runs
                of a robot that it draws itself, so that the truth is known.
                """
            ),
            folder,
        ]
    )
    return (folder,)


@app.cell
def _(folder, identification):
    from experiments.virtual_rig.recovery import campaign as generated
    from experiments.virtual_rig.recovery import draw

    truth = None if folder.value else draw(4)
    campaign = (
        identification.read_campaign(folder.value) if folder.value else generated(truth, 4)
    )
    campaign
    return campaign, truth


@app.cell
def _(campaign, mo):
    # Before anything is fitted: do the sensors contradict each other?
    from identification.doctor import examine

    findings = [each for each in examine(campaign) if each.severity != "note"]
    told = "\n".join(f"- **{each.severity}**: {each}" for each in findings)
    mo.md(
        "## Do the sensors agree?\n\n" + (told or "Yes: no two of them contradict each other.")
    )
    return


@app.cell
def _(campaign, identification, mo):
    with mo.status.spinner(title="fitting all runs at once"):
        estimate = identification.estimate(campaign)
    return (estimate,)


@app.cell
def _(estimate, mo, truth):
    from experiments.page.number_text import readable_unit, rounded

    def row(own):
        true = "" if truth is None or own.name not in truth.values else truth.values[own.name]
        shown = rounded(true, own.sigma) if true != "" else ""
        low, high = (rounded(end, own.sigma) for end in own.interval95)
        return (
            f"| {own.label.replace('_', ' ')} [{readable_unit(own.unit)}] | "
            f"{rounded(own.value, own.sigma)} | {low} … {high} | {own.status} | {shown} |"
        )

    rows = [row(own) for own in estimate.parameters if own.status != "fixed"]
    verdict = (
        "The model explains what was measured."
        if estimate.fits
        else "**The model does not explain these runs: don't use the numbers.**"
    )
    mo.md(
        "\n".join(
            [
                "## What is the robot?",
                "",
                verdict,
                "",
                "| quantity | estimate | 95 % | status | truth |",
                "| --- | --- | --- | --- | --- |",
                *rows,
            ]
        )
    )
    return


@app.cell
def _(estimate):
    from experiments.figures.identification.run_comparison import run_comparison

    # The run that the model explains the least, its measurements under its simulation.
    worst = max(
        (own for own in estimate.comparisons if own.channels),
        key=lambda own: max(channel.rms / channel.sigma for channel in own.channels),
    )
    run_comparison(worst)
    return (worst,)


@app.cell
def _(campaign, identification, mo):
    try:
        heard = repr(identification.frequency_map(campaign))
    except ValueError as why:
        # The example's knock is logged for a second and a half only.
        heard = str(why)
    mo.md(f"## Where does it ring?\n\n```\n{heard}\n```")
    return


@app.cell
def _(estimate, mo, np, truth, worst):
    inside = (
        ""
        if truth is None
        else "- Of the four true values, "
        + str(
            sum(
                own.interval95[0] <= truth.values[own.name] <= own.interval95[1]
                for own in estimate.parameters
                if own.name in truth.values
            )
        )
        + " are inside their 95 % intervals; one outside in twenty is as it should be.\n"
    )
    most = max(channel.rms / channel.sigma for channel in worst.channels)
    together = np.abs(estimate.correlation - np.eye(len(estimate.correlation))).max()
    mo.md(
        f"""
## What surprised

{inside}- The run that is explained the least, {worst.name}, is off by {most:.2f} of its
  sensors' noise.
- Two of the quantities go together by {together:.2f} (1 would be one and the same): what one
  run can't tell apart, another one of another kind can. `scdpr design` names it.
"""
    )
    return


if __name__ == "__main__":
    app.run()
