import numpy as np

from identification.data.record import readings, windowed


def test_a_reading_that_stands_is_one_measurement():
    angle = np.array([[0.0, 0.0], [0.0, 1.0], [0.0, 2.0], [1.0, 2.0]])
    np.testing.assert_allclose(
        readings(angle), [[1 / 3, 1], [1 / 3, 1], [1 / 3, 0.5], [1, 0.5]]
    )


def test_windows_of_a_coarser_grid_hold_every_sample_once():
    samples = np.arange(2 * 23 * 2.0).reshape(2, 23, 2)
    for factor in (1, 2, 5, 7):
        np.testing.assert_allclose(windowed(samples, factor).sum(axis=1), samples.sum(axis=1))


def test_a_window_lies_about_its_instant():
    time = np.repeat(np.arange(21.0)[None, :, None], 2, axis=2)
    mean = windowed(time, 5) / windowed(np.ones_like(time), 5)
    np.testing.assert_allclose(mean[0, 1:-1, 0], [5.0, 10.0, 15.0])
