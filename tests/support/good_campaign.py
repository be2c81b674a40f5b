"""A small campaign without a fault, as files; tests spoil one of them."""

import pathlib

CAMPAIGN = """\
format = 1
name = "small rig"
counts_per_rev = 1000

[robot]
effective_radius = "73 mm"
friction_coefficient = "1.8 %"

[sensors]
camera_angle_sigma = "1 mrad"
"""

STEP = """\
format = 1
kind = "torque_step"
pretension = "0.35 kN"
notes = "slow"

[initial]
x_e = "173 mm"
y_e = "0.300 m"

[camera]
clock_offset = "2 ms"
"""

KNOCK = """\
format = 1
kind = "pseudo_impulse"
pretension = "200 N"

[knock]
start = "1 ms"
duration = "1 ms"

[camera]
clock_offset = "unknown"
"""

DRIVE = """\
t [ms],voltage_1 [mV],voltage_2 [V],alpha_1 [count],alpha_2 [deg],current_1 [mA],current_2 [A]
0,0,0.0,0,0,0,0
1,1500,-1.5,0,0,12,0.5
2,1500,-1.5,250,-180,13,0.5
3,1500,-1.5,500,-360,14,0.5
"""

CAMERA = """\
t [us],x_e [mm],y_e [cm],delta_e [deg],q_3 [m],q_4 [m]
0,26,30,0,0.026,0.026
2000,27,,1.8,0.027,
4000,28,30,3.6,0.028,0.028
"""


def write(folder: pathlib.Path) -> pathlib.Path:
    """Writes the campaign and returns its folder."""
    (folder / "0001-step").mkdir(parents=True)
    (folder / "0002-knock").mkdir()
    texts = {
        "campaign.toml": CAMPAIGN,
        "0001-step/run.toml": STEP,
        "0001-step/drive.csv": DRIVE,
        "0001-step/camera.csv": CAMERA,
        "0002-knock/run.toml": KNOCK,
        "0002-knock/drive.csv": DRIVE,
    }
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    return folder
