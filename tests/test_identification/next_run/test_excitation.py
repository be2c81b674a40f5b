import numpy as np
import pytest

from identification.next_run.excitation import REST, STEP, TAIL, catalogue, moving

POSES = ((0.3, 0.55), (1.1, 0.4))


@pytest.fixture(scope="module")
def excitations():
    return catalogue(limit=10.0, duration=2.0, poses=POSES)


def test_every_excitation_keeps_within_the_voltage_limit(excitations):
    assert all(np.max(np.abs(one.voltage)) <= 10.0 for one in excitations)


def test_every_excitation_rests_before_it_moves_and_rings_after(excitations):
    for one in excitations:
        assert not one.voltage[: round(REST / STEP)].any()
        assert not one.voltage[-round(TAIL / STEP) :].any()


def test_every_excitation_either_moves_the_drives_or_knocks(excitations):
    assert all((one.knock != 0) != np.any(one.voltage != 0) for one in excitations)


def test_every_shape_is_there_from_every_pose_at_half_and_full_length(excitations):
    shapes = {one.name.split(",")[0] for one in excitations if not one.knock}
    for shape in shapes:
        of_shape = [one for one in excitations if one.name.startswith(f"{shape},")]
        assert {one.start for one in of_shape} == set(POSES)
        assert {round(one.duration, 9) for one in of_shape} == {1.0, 2.0}


def test_a_multisine_reaches_its_amplitude(excitations):
    multisines = [
        one for one in excitations if one.name == "multisine 1 to 5 Hz, sideways, 90%"
    ]
    np.testing.assert_allclose([np.max(np.abs(one.voltage)) for one in multisines], 9.0)


def test_a_run_without_time_to_move_is_refused():
    with pytest.raises(ValueError, match="Allow for a longer run"):
        catalogue(limit=10.0, duration=1.0, poses=POSES)


def test_nothing_moves_in_rest_and_tail():
    assert np.flatnonzero(moving(100)).tolist() == list(range(20, 70))
