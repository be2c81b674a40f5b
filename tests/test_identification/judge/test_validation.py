import numpy as np
import pytest

from identification.judge.validation import LEVEL, ChannelValidation, independence, ljung_box

COUNT = 400


def draws(make, number=200):
    random = np.random.default_rng(3)
    return [make(random) for _ in range(number)]


def test_white_residuals_pass_as_often_as_the_level_says():
    failed = sum(p < 0.05 for p in draws(lambda r: ljung_box(r.normal(size=COUNT))))
    # 200 draws at 5 %: ten, and three standard deviations of a binomial are nine more.
    assert failed <= 19


def test_residuals_that_hang_together_do_not():
    def walk(random):
        noise = random.normal(size=COUNT)
        return ljung_box(noise[1:] + 0.5 * noise[:-1])

    assert max(draws(walk, 50)) < LEVEL


def square(length=50):
    return np.sign(np.sin(2 * np.pi * np.arange(COUNT) / length) + 1e-9)


def test_residuals_that_know_nothing_of_the_voltage_pass():
    failed = sum(
        p < 0.05 for p in draws(lambda r: independence(r.normal(size=COUNT), square()))
    )
    assert failed <= 19


@pytest.mark.parametrize("lag", [0, 5])
def test_residuals_that_follow_the_voltage_do_not(lag):
    def followed(random):
        return independence(random.normal(size=COUNT) + 0.5 * np.roll(square(), lag), square())

    assert max(draws(followed, 50)) < LEVEL


def test_a_voltage_that_stands_tells_nothing():
    assert independence(np.random.default_rng(0).normal(size=COUNT), np.zeros(COUNT)) == 1.0


def test_an_encoders_rounding_is_noise_though_it_is_not_white():
    verdict = ChannelValidation("0001", "alpha_1", False, 1.0, 1e-9, 1e-9, True).verdict
    assert verdict == "noise"
