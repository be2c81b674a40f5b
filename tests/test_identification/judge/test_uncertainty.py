import numpy as np
import pytest

from identification.judge.uncertainty import (
    ParameterEstimate,
    covariance,
    half_width,
    interval95,
    is_undetermined,
    judge,
)

RUNS, BLOCKS, SAMPLES = 12, 40, 10


def regression(noise, design):
    """A line fitted to every run at once: matrix, scores and the estimate."""
    matrix = np.einsum("rbsn,rbsm->nm", design, design)
    estimate = np.linalg.solve(matrix, np.einsum("rbsn,rbs->n", design, noise))
    residual = noise - design @ estimate
    return matrix, np.einsum("rbsn,rbs->rbn", design, residual), estimate


def coverage(make_noise, draws=200):
    """How often the 95 % interval of both coefficients holds the truth, 0."""
    random = np.random.default_rng(5)
    inside = 0
    for _ in range(draws):
        design = np.stack(
            [np.ones((RUNS, BLOCKS, SAMPLES)), random.normal(size=(RUNS, BLOCKS, SAMPLES))], -1
        )
        matrix, scores, estimate = regression(make_noise(random), design)
        found = covariance(matrix, scores, np.array([True, True]))
        both = zip(found.sigma, found.degrees_of_freedom, strict=True)
        half = np.array([half_width(s, 0.95, freedom) for s, freedom in both])
        inside += np.count_nonzero(np.abs(estimate) <= half)
    return inside / (2 * draws)


def white(random):
    return random.normal(size=(RUNS, BLOCKS, SAMPLES))


def standing_still(random):
    """Errors that stand for a whole run, as an encoder's rounding at rest does."""
    return white(random) + random.normal(size=(RUNS, 1, 1))


@pytest.mark.parametrize("noise", [white, standing_still])
def test_intervals_cover_for_white_and_for_standing_errors(noise):
    # 400 intervals: three standard deviations of a binomial below 95 % are 91.7 %.
    assert coverage(noise) >= 0.917


def test_intervals_cover_with_a_number_measured_otherwise_beside_standing_errors():
    """Its error is its own and as stated, whatever the runs' residuals do."""
    random, inside, draws = np.random.default_rng(6), 0, 400
    for _ in range(draws):
        noise, design = standing_still(random), np.ones((RUNS, BLOCKS, SAMPLES, 1))
        # The runs know their mean to 0.3, whatever their number of samples says.
        information = np.array([[1 / 0.3**2]])
        other = random.normal(scale=0.3)
        matrix = np.einsum("rbsn,rbsm->nm", design, design)
        whole = matrix + information
        estimate = np.linalg.solve(whole, [noise.sum() + information[0, 0] * other])
        scores = np.einsum("rbsn,rbs->rbn", design, noise - estimate[0])
        found = covariance(whole, scores, np.array([True]), otherwise=information)
        half = half_width(found.sigma[0], 0.95, found.degrees_of_freedom[0])
        inside += abs(estimate[0]) <= half
    assert inside / draws >= 0.917


def test_white_noise_intervals_would_not_cover_standing_errors():
    random = np.random.default_rng(5)
    outside = 0
    for _ in range(100):
        design = np.ones((RUNS, BLOCKS, SAMPLES, 1))
        matrix, _, estimate = regression(standing_still(random), design)
        outside += abs(estimate[0]) > 1.96 / np.sqrt(matrix[0, 0])
    assert outside > 50


def test_what_no_run_shows_has_no_standard_error():
    matrix = np.array([[4.0, 0.0], [0.0, 0.0]])
    found = covariance(matrix, np.zeros((3, BLOCKS, 2)), np.array([True, False]))
    assert found.sigma[0] == 0.5
    assert np.isinf(found.sigma[1])
    assert half_width(found.sigma[1], 0.95, 3.0) == np.inf


@pytest.mark.parametrize(
    ("name", "number", "sigma", "untold"),
    [
        ("drive_inertia", 0.01, 0.5, False),
        ("drive_inertia", 0.01, 1.5, True),
        ("friction_coefficient", 0.01, 0.05, False),
        ("friction_coefficient", 0.01, 0.2, True),
        ("friction_coefficient", 0.01, np.inf, True),
        ("drive_friction", 0.0, 0.01, False),
    ],
)
def test_an_interval_that_says_nothing_of_the_robot_is_not_given(name, number, sigma, untold):
    assert is_undetermined(name, number, sigma) == untold


@pytest.mark.parametrize(
    ("sigma", "at_bound", "status"),
    [
        (0.01, False, "identified"),
        (0.2, False, "weak"),
        (1.5, False, "unidentifiable"),
        (0.01, True, "at_bound"),
        (np.inf, False, "unidentifiable"),
    ],
)
def test_a_value_is_judged_by_its_relative_error(sigma, at_bound, status):
    assert judge("drive_inertia", 1.0, sigma, at_bound=at_bound) == status


def test_what_may_as_well_be_zero_is_judged_by_its_usual_size():
    # A millionth of what the drives can do, and known to half of that.
    assert judge("drive_friction", 1e-6, 5e-7, at_bound=False) == "identified"
    assert judge("drive_friction", 1e-6, 1e-2, at_bound=False) == "unidentifiable"


def test_a_friction_near_zero_is_known_as_well_as_its_uncut_interval_says():
    friction = ParameterEstimate(
        "drive_friction",
        None,
        1e-3,
        "N m",
        1e-3,
        interval95("drive_friction", 1e-3, 1e-3, np.inf),
        "weak",
    )
    low, high = friction.interval95
    assert low == 0.0
    assert high - friction.value == friction.half_width
    # A tenth of the usual 0.05 N m is what is negligible.
    assert friction.relative == pytest.approx(1.96e-3 / 5e-3, rel=1e-3)
