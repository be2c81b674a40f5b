"""The free vibration after a knock: measured, fitted, and its spectrum."""

from matplotlib.figure import Figure

from experiments.page import style
from experiments.page.number_text import rounded
from experiments.studies.findings.knocks import KnockDecay


@style.styled
def ring_down_figure(decay: KnockDecay) -> Figure:
    """A knock's displacement with its fitted decay, and its spectrum.

    Args:
        decay: The decay.

    Returns:
        The figure.
    """
    fit = decay.ring_down
    figure, (left, right) = style.panels(1, 2, widths=(1.5, 1.0), width=8.3, height=2.6)
    left.plot(
        decay.time,
        1e3 * decay.displacement,
        "o",
        ms=2.8,
        color=style.BLUE,
        alpha=0.8,
        label="camera",
        zorder=3,
    )
    left.plot(
        decay.curve_time, 1e3 * decay.curve, color=style.VERMILION, lw=1.4, label="fitted decay"
    )
    left.axvspan(*fit.window, color="#ececec", zorder=0, label="fitted window")
    left.set(xlabel="camera time [s]", ylabel="xₑ [mm]")
    style.legend_above(left)
    # Beyond four times the strongest mode there is noise alone.
    shown = decay.frequency <= min(decay.frequency[-1], 4 * fit.frequency)
    right.plot(decay.frequency[shown], 1e3 * decay.amplitude[shown], color=style.BLUE, lw=1.2)
    right.axvline(fit.frequency, color=style.VERMILION, lw=1.2)
    right.set(xlabel="frequency [Hz]", ylabel="amplitude [mm]")
    sigma = fit.frequency_sigma
    right.set_title(
        f"{rounded(fit.frequency, sigma)} ± {rounded(sigma, sigma)} Hz",
        color=style.RED_WORDS,
    )
    right.set_ylim(bottom=0)
    right.axvline(fit.fft_frequency, color=style.GREY, ls=":", lw=1.2)
    return figure
