import itertools

import numpy as np

from tuning.gains.cross_entropy import cross_entropy

PLACE = np.array([1.5, -0.5, 0.25])


def bowl(designs):
    return np.sum((designs - PLACE) ** 2, axis=1)


def search(losses, *, generations, seed=0):
    return cross_entropy(
        losses,
        np.zeros(3),
        np.eye(3),
        population=40,
        generations=generations,
        seed=seed,
    )


def test_the_bottom_of_a_bowl_is_found():
    found = search(bowl, generations=40)
    # What is added to the covariance each time keeps a width of some 3e-3.
    np.testing.assert_allclose(found.best, PLACE, atol=0.02)
    assert found.loss == bowl(found.best[None])[0]


def test_the_best_never_gets_worse():
    losses = [search(bowl, generations=n).loss for n in range(1, 8)]
    assert all(later <= before for before, later in itertools.pairwise(losses))


def test_the_same_seed_finds_the_same():
    first, second = (search(bowl, generations=5, seed=7).best for _ in range(2))
    np.testing.assert_array_equal(first, second)


def test_what_is_no_number_is_never_the_best():
    found = search(lambda d: np.where(d[:, 0] > 1, np.nan, bowl(d)), generations=20)
    assert found.best[0] <= 1
    assert np.isfinite(found.loss)
