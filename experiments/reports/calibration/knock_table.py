"""The natural frequencies of the knocks as a table."""

from experiments.page.number_text import rounded
from experiments.page.table import Table
from identification.knocks.frequency_map import FrequencyMap


def knock_table(frequencies: FrequencyMap) -> Table:
    """Every knock's frequency and damping for the terminal.

    Args:
        frequencies: The map.

    Returns:
        The table.
    """
    header = ("run", "x [mm]", "y [mm]", "T [N]", "f [Hz]", "± σ", "damping [1]", "± σ")
    rows = tuple(
        (*_pose(frequencies, row), *_frequency(frequencies, row), *_damping(frequencies, row))
        for row in range(len(frequencies.runs))
    )
    return Table("Natural frequencies", header, rows, spare=((3,),))


def knock_table_with_fft(frequencies: FrequencyMap) -> Table:
    """The same for a page: beside the paper's peak picking, and whether noise is left.

    Args:
        frequencies: The map.

    Returns:
        The table.
    """
    header = ("run", "x [mm]", "y [mm]", "T [N]", "f [Hz]", "± σ", "FFT [Hz]", "damping")
    rows = tuple(
        (
            *_pose(frequencies, row),
            *_frequency(frequencies, row),
            rounded(float(frequencies.fft_frequency[row]), 1e-2),
            *_damping(frequencies, row),
            "noise" if frequencies.residuals_are_noise[row] else "more than noise",
        )
        for row in range(len(frequencies.runs))
    )
    return Table("", (*header, "± σ", "residuals"), rows, words=(0, 9))


def _pose(frequencies: FrequencyMap, row: int) -> tuple[str, ...]:
    return (
        frequencies.runs[row],
        f"{1e3 * float(frequencies.x[row]):.1f}",
        f"{1e3 * float(frequencies.y[row]):.1f}",
        f"{float(frequencies.pretension[row]):g}",
    )


def _frequency(frequencies: FrequencyMap, row: int) -> tuple[str, str]:
    sigma = float(frequencies.frequency_sigma[row])
    return rounded(float(frequencies.frequency[row]), sigma), rounded(sigma, sigma)


def _damping(frequencies: FrequencyMap, row: int) -> tuple[str, str]:
    sigma = float(frequencies.damping_ratio_sigma[row])
    return rounded(float(frequencies.damping_ratio[row]), sigma), rounded(sigma, sigma)
