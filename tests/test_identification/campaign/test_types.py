import dataclasses

from report_samples import campaign, skipped_run


def test_a_campaign_tells_its_runs_in_a_few_lines():
    made = dataclasses.replace(campaign(skipped=skipped_run()), robot={"drive_damping": 0.2})
    lines = repr(made).splitlines()
    assert lines[0] == "Campaign 'a rig': 4 runs, 8 s"
    assert lines[1] == "  2 manoeuvre, 1 pseudo_impulse, 1 motor_step"
    assert lines[2:] == [
        "  at 350 N",
        "  stated of the robot: drive_damping",
        "  left out: 0009-x",
    ]
