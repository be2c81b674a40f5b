"""Ring-downs with known modes: coverage, sliding carriages, second modes, silence."""

import dataclasses

import knock_recording
import numpy as np
import pytest
import scipy.stats

from identification.knocks.ring_down import ring_down

NOISE = 0.19e-3
SEEDS = 50


def camera(random, *, duration=3.0):
    return np.arange(0.02, duration, 1 / 30) + random.uniform(
        -1.5e-3, 1.5e-3, round(30 * 2.98) + 1
    )


def knock(
    seed, *, frequency=3.1, ratio=0.01, amplitude=5e-3, second=0.0, slide=0.0, noise=NOISE
):
    """Camera record of a knock at 0.3 s: vibration, and optionally a sliding carriage."""
    random = np.random.default_rng(seed)
    time = camera(random)
    t = np.maximum(time - 0.3, 0.0)
    natural = 2 * np.pi * frequency
    damped = natural * np.sqrt(1 - ratio**2)
    phase = random.uniform(0, 2 * np.pi)
    x = amplitude * np.exp(-ratio * natural * t) * np.cos(damped * t + phase)
    x = x + second * np.cos(2 * np.pi * 8.7 * t + 1.0)
    # Friction brings the carriage to rest at 1 s: a parabola, and higher frequency before.
    x = x + slide * np.maximum(1.0 - time, 0.0) ** 2
    x = np.where(time < 0.3, 0.0, x)
    x = x + noise * random.normal(size=len(time))
    x[random.choice(len(time), 5, replace=False)] = np.nan
    return time, 1.2 + x


def fit(seed, **changes):
    time, x = knock(seed, **changes)
    return ring_down(time, x, noise_sigma=NOISE, after=0.4)


def covers(value, sigma, truth):
    return abs(value - truth) <= 1.96 * sigma


@pytest.mark.parametrize(("ratio", "amplitude"), [(0.0, 5e-3), (0.02, 2e-3)])
def test_the_intervals_cover_the_truth_as_often_as_they_say(ratio, amplitude):
    decays = [fit(seed, ratio=ratio, amplitude=amplitude) for seed in range(SEEDS)]
    frequency = sum(covers(d.frequency, d.frequency_sigma, 3.1) for d in decays)
    damping = sum(covers(d.damping_ratio, d.damping_ratio_sigma, ratio) for d in decays)
    # Binomial 0.1 % quantiles at 95 %, and no wider than they need be: the bound at 0 takes
    # half of the misses away where there is no damping, so only frequency is held to that.
    low, high = scipy.stats.binom.ppf([0.001, 0.999], SEEDS, 0.95)
    assert low <= frequency <= high
    assert low <= damping


def test_a_sliding_carriage_is_waited_for():
    decays = [fit(seed, slide=0.05) for seed in range(8)]
    inside = sum(covers(d.frequency, d.frequency_sigma, 3.1) for d in decays)
    assert inside >= scipy.stats.binom.ppf(0.001, 8, 0.95)
    # It slides until 1 s, by 0.05 (1 - t)² m: under the noise of 0.19 mm from 0.94 s on.
    assert np.median([d.window[0] for d in decays]) > 0.6


def giving_way(seed):
    """A knock whose carriage gives way a little at each of the first swings.

    The frequency begins 0.08 Hz higher. What that leaves of one decaying sine is below the
    noise, and the sine's frequency is five standard errors off.
    """
    random = np.random.default_rng(seed)
    time = camera(random)
    t = np.maximum(time - 0.3, 0.0)
    turns = 3.1 * t + 0.08 * 0.4 * (1 - np.exp(-t / 0.4))
    x = 6e-3 * np.exp(-0.2 * t) * np.sin(2 * np.pi * turns)
    return time, x + NOISE * random.normal(size=time.size)


def test_a_change_that_hides_below_the_noise_is_looked_for():
    decays = [ring_down(*giving_way(seed), noise_sigma=NOISE, after=0.4) for seed in range(16)]
    # None of them by tests of the residuals' size and of their neighbours alone.
    assert sum(covers(d.frequency, d.frequency_sigma, 3.1) for d in decays) >= 6


def test_a_second_mode_is_fitted_beside_the_first_where_it_shows():
    decay = fit(3, second=1e-3)
    assert len(decay.modes) == 2
    assert covers(decay.frequency, 2 * decay.frequency_sigma, 3.1)
    other = decay.modes[1]
    assert covers(other.frequency, 2 * other.frequency_sigma, 8.7)
    assert other.amplitude == pytest.approx(1e-3, abs=5 * NOISE / np.sqrt(30))


def test_one_mode_is_enough_where_there_is_one():
    modes = [len(fit(seed).modes) for seed in range(30)]
    # Schwarz's price for a mode of four parameters: it is paid by chance once in 1e2.
    assert np.mean(np.array(modes) == 1) > 0.9


def test_residuals_that_are_not_noise_are_said_and_widen_the_interval():
    quiet = fit(5)
    time, x = knock(5)
    # A vibration that decays linearly, as Coulomb friction makes it, is no exponential.
    t = np.maximum(time - 0.3, 0.0)
    dry = 8e-3 * np.maximum(1 - t / 2.4, 0) * np.cos(2 * np.pi * (3.1 + 0.1 * np.exp(-t)) * t)
    decay = ring_down(time, x + dry, noise_sigma=NOISE / 3, after=0.4)
    assert quiet.residuals_are_noise
    assert not decay.residuals_are_noise
    assert decay.chi_square > 2
    assert decay.frequency_sigma > quiet.frequency_sigma


def test_peak_picking_agrees_within_its_resolution():
    decay = fit(7)
    assert abs(decay.fft_frequency - decay.frequency) < 0.25 * decay.fft_resolution


def test_damping_is_never_reported_below_zero():
    ratios = [fit(seed, ratio=0.0).damping_ratio for seed in range(20)]
    assert min(ratios) == 0.0
    assert max(ratios) > 0.0


@pytest.mark.parametrize("seed", range(5))
def test_noise_alone_is_no_vibration(seed):
    with pytest.raises(ValueError, match=r"the knock rang less than about 0\.16 mm"):
        fit(seed, amplitude=0.0)


def test_a_record_that_ends_too_early_is_refused():
    time, x = knock(0)
    with pytest.raises(
        ValueError, match=r"samples with a position after 2 s, expected at least"
    ):
        ring_down(time, x, noise_sigma=NOISE, after=2.0)


def test_noise_that_is_not_positive_is_refused():
    time, x = knock(0)
    with pytest.raises(ValueError, match=r"`noise_sigma` must be positive \[m\], got 0.0"):
        ring_down(time, x, noise_sigma=0.0, after=0.4)


def test_a_ring_down_is_plain_data():
    decay = fit(1)
    assert all(
        isinstance(getattr(decay, field.name), (float, bool, tuple))
        for field in dataclasses.fields(decay)
    )


def slackening(seed):
    """What a carriage that comes to rest leaves: a swing that slows as it dies away."""
    random = np.random.default_rng(seed)
    time = camera(random)
    t = np.maximum(time - 0.3, 0.0)
    x = 5.8e-3 * np.exp(-3.2 * t) * np.sin(2 * np.pi * 5.37 * t)
    x += 2.1e-3 * np.exp(-0.2 * t) * np.sin(2 * np.pi * 5.055 * t)
    return time, x + NOISE * random.normal(size=time.size)


def test_modes_within_each_others_width_are_one_whose_frequency_changes():
    for seed in range(4):
        time, x = slackening(seed)
        decay = ring_down(time, x, noise_sigma=NOISE, after=0.38)
        assert abs(decay.frequency - 5.055) < 0.05


def test_a_frame_more_or_less_after_the_knock_changes_no_frequency():
    for seed in range(4):
        time, x = slackening(seed)
        ends = [
            ring_down(time, x, noise_sigma=NOISE, after=after).frequency
            for after in (0.37, 0.40, 0.43)
        ]
        assert np.ptp(ends) < 0.01 * 5.055


def test_a_knock_that_is_called_more_than_noise_by_chance_is_told_by_all_of_its_samples():
    """Cut 0.7 s shorter, this one's first window fails the test of noise at 1 %."""
    run = knock_recording.recording(0).single.runs[38]
    time, x_e = run.camera.time, run.camera.position[:, 0]
    after = run.knock.start + 0.08
    whole, cut = (
        ring_down(time[kept], x_e[kept], noise_sigma=1.9e-4, after=after)
        for kept in (time > 0, time < 615.9)
    )
    assert abs(cut.window[0] - whole.window[0]) < 0.25  # one of sixteen windows
    assert cut.residuals_are_noise
    # As many samples but for those in which nothing is left.
    assert abs(cut.frequency - whole.frequency) < 0.5 * whole.frequency_sigma
    assert cut.frequency_sigma < 1.2 * whole.frequency_sigma
