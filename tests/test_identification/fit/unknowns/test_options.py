from short_runs import bare_run

from identification.campaign import Campaign
from identification.fit.unknowns.measured import MeasuredQuantity
from identification.fit.unknowns.options import FitOptions
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace, value

MASS = MeasuredQuantity(quantity="end_effector_mass", value=2.0, sigma=0.01)


def test_a_quantity_that_was_measured_is_free_once():
    options = FitOptions(free=["end_effector_mass", "drive_inertia"], measured=[MASS])
    assert options.all_free == ("end_effector_mass", "drive_inertia")


def test_what_the_campaign_states_replaces_what_the_robot_was_taken_for():
    robot = replace(consistent(), {"drive_inertia": 0.02, "drive_damping": 0.3})
    runs = (bare_run("torque_step"),)
    campaign = Campaign(name="stated", runs=runs, robot={"drive_damping": 0.4})
    prior = FitOptions(robot=robot).prior(campaign)
    assert float(value(prior, "drive_inertia")) == 0.02
    assert float(value(prior, "drive_damping")) == 0.4
