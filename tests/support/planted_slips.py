"""Slips planted in good campaigns: one function each, and which runs it spoils."""

import dataclasses
import math
from collections.abc import Callable, Sequence

import numpy as np
from slip_changes import (
    HEIGHT,
    Q3,
    Q4,
    RAD,
    WIDTH,
    Change,
    D,
    X,
    Y,
    angles,
    before_limit,
    camera_gap,
    chain,
    clock_jump,
    cut,
    drive,
    drive_gap,
    jump,
    labelled,
    last_value,
    lateral,
    lost,
    no_knock,
    other_marker,
    places,
    still,
    stuck_angle,
    stuck_place,
    stuck_volts,
    swap,
    swap_carriages,
    times,
    volts,
    wrapped,
    wrong_knock,
)

from identification.campaign import Campaign, Run

Plant = Callable[[Campaign, np.random.Generator], Campaign]


def each_run(
    campaign: Campaign, change: Change, names: Sequence[str] | None = None
) -> Campaign:
    runs = tuple(
        change(run) if names is None or run.name in names else run for run in campaign.runs
    )
    return dataclasses.replace(campaign, runs=runs)


def moving_runs(campaign: Campaign) -> list[str]:
    return [r.name for r in campaign.runs if r.camera is not None and np.ptp(r.drive.angle) > 3]


def knocked(campaign: Campaign) -> list[str]:
    return [r.name for r in campaign.runs if r.kind == "pseudo_impulse"]


def everywhere(change: Change) -> Plant:
    return lambda campaign, random: each_run(campaign, change)


def in_one(change: Change, pick: Callable[[Campaign], list[str]] = moving_runs) -> Plant:
    def plant(campaign: Campaign, random: np.random.Generator) -> Campaign:
        return each_run(campaign, change, [str(random.choice(pick(campaign)))])

    return plant


def doubled(campaign: Campaign, random: np.random.Generator) -> Campaign:
    run = campaign.run(str(random.choice(moving_runs(campaign))))
    copy = dataclasses.replace(run, name=run.name + "-again")
    return dataclasses.replace(campaign, runs=(*campaign.runs, copy))


def steps(campaign: Campaign) -> list[str]:
    return [r.name for r in campaign.runs if r.kind == "torque_step"]


def manoeuvres(campaign: Campaign) -> list[str]:
    return [r.name for r in campaign.runs if r.kind == "manoeuvre"]


MIRROR_X = places(-1.0, (X, Q3, Q4), WIDTH)
MIRROR_Y = places(-1.0, (Y,), HEIGHT)


PLANTED: dict[str, tuple[str, Plant]] = {
    "degrees labelled rad": ("unit.alpha", everywhere(angles(1 / RAD))),
    "rad labelled degrees": ("unit.alpha", everywhere(angles(RAD))),
    "revolutions labelled rad": ("unit.alpha", everywhere(angles(1 / (2 * math.pi)))),
    "rad labelled revolutions": ("unit.alpha", everywhere(angles(2 * math.pi))),
    "delta in degrees": ("unit.delta_e", everywhere(places(1 / RAD, (D,)))),
    "delta labelled degrees": ("unit.delta_e", everywhere(places(RAD, (D,)))),
    "mm labelled m": ("unit.position", everywhere(places(1e3))),
    "m labelled mm": ("unit.position", everywhere(places(1e-3))),
    "cm labelled mm": ("unit.position", everywhere(places(0.1))),
    "mm labelled cm": ("unit.position", everywhere(places(10))),
    "mV labelled V": ("unit.voltage", everywhere(volts(1e3))),
    "V labelled mV": ("unit.voltage", everywhere(volts(1e-3))),
    "per mille": ("unit.voltage", everywhere(volts(100))),
    "per cent": ("unit.voltage", everywhere(volts(10))),
    "share of the limit": ("unit.voltage", everywhere(volts(0.1))),
    "amperes": ("unit.voltage", everywhere(volts(0.6))),
    "drive ms as s": ("unit.time_drive", everywhere(times(of_drive=1e3))),
    "drive s as ms": ("unit.time_drive", everywhere(times(of_drive=1e-3))),
    "camera ms as s": ("unit.time_camera", everywhere(times(of_camera=1e3))),
    "camera s as ms": ("unit.time_camera", everywhere(times(of_camera=1e-3))),
    "both ms as s": ("unit.time", everywhere(times(of_drive=1e3, of_camera=1e3))),
    "both s as ms": ("unit.time", everywhere(times(of_drive=1e-3, of_camera=1e-3))),
    "rate doubled": ("rate.drive", everywhere(times(of_drive=0.5))),
    "rate halved": ("rate.drive", everywhere(times(of_drive=2.0))),
    "rate of 800": ("rate.drive", everywhere(times(of_drive=0.8))),
    "rate by ten": ("rate.drive", everywhere(times(of_drive=10.0))),
    "motor 1": ("sign.motor_1", everywhere(chain(angles(-1, (0,)), volts(-1, (0,))))),
    "motor 2": ("sign.motor_2", everywhere(chain(angles(-1, (1,)), volts(-1, (1,))))),
    "voltage 1": ("sign.voltage_1", everywhere(volts(-1, (0,)))),
    "voltage 2": ("sign.voltage_2", everywhere(volts(-1, (1,)))),
    "alpha 1": ("sign.alpha_1", everywhere(angles(-1, (0,)))),
    "alpha 2": ("sign.alpha_2", everywhere(angles(-1, (1,)))),
    "x leftwards": ("sign.x_e", everywhere(MIRROR_X)),
    "x negative": ("sign.x_e", everywhere(places(-1, (X, Q3, Q4)))),
    "x_e alone leftwards": ("sign.x_e", everywhere(places(-1, (X,), WIDTH))),
    "y downwards": ("sign.y_e", everywhere(MIRROR_Y)),
    "y negative": ("sign.y_e", everywhere(places(-1, (Y,)))),
    "delta reversed": ("sign.delta_e", everywhere(places(-1, (D,)))),
    "motors": ("swap.motors", everywhere(chain(swap("angle"), swap("voltage")))),
    "voltages": ("swap.voltages", everywhere(swap("voltage"))),
    "alphas": ("swap.alphas", everywhere(swap("angle"))),
    "carriages": ("swap.carriages", everywhere(swap_carriages)),
    "radius is diameter": ("scale.alpha", everywhere(angles(0.5))),
    "counts by four": ("scale.alpha", everywhere(angles(4))),
    "motor side": ("scale.alpha", everywhere(angles(26))),
    "motor side of one": ("scale.alpha", everywhere(angles(26, (1,)))),
    "counts by two, one encoder": ("scale.alpha", everywhere(angles(2, (0,)))),
    "one encoder in degrees": ("unit.alpha", everywhere(angles(1 / RAD, (0,)))),
    "y_e in cm": ("unit.position", everywhere(places(10, (Y,)))),
    "q_3 in mm as m": ("unit.position", everywhere(places(1e3, (Q3,)))),
    "x_e in cm as m": ("unit.position", everywhere(places(1e2, (X,)))),
    "camera 3 %": ("scale.camera", everywhere(places(1.03))),
    "camera -4 %": ("scale.camera", everywhere(places(0.96))),
    "offset of 0.2 s": ("clock.offset", everywhere(times(shift=0.2))),
    "offset of -40 ms": ("clock.offset", everywhere(times(shift=-0.04))),
    "offset of 12 ms": ("clock.offset", everywhere(times(shift=0.012))),
    "offset of 3 s": ("clock.offset", everywhere(times(shift=3.0))),
    "drift of 1 %": ("clock.drift", everywhere(times(of_camera=1.01))),
    "drift of 0.3 %": ("clock.drift", everywhere(times(of_camera=0.997))),
    "wraps at a turn": ("wrap.alpha", everywhere(wrapped(2 * math.pi))),
    "wraps at 2^16": ("wrap.alpha", everywhere(lambda r: r)),
    "jump of 0.3 rad": ("jump.alpha", in_one(jump(0.3))),
    "jump of 0.1 rad": ("jump.alpha", in_one(jump(-0.1))),
    "stuck angle": ("stuck.alpha", in_one(stuck_angle, steps)),
    "stuck volts": ("stuck.voltage", in_one(stuck_volts, steps)),
    "stuck x_e": ("stuck.camera", in_one(stuck_place(X))),
    "stuck q_3": ("stuck.camera", in_one(stuck_place(Q3))),
    "lost as 0": ("lost_as_value", in_one(lost(0.0))),
    "lost as -1 mm": ("lost_as_value", in_one(lost(-1e-3))),
    "lost as the last": ("lost_as_value", in_one(last_value)),
    "other marker": ("swapped_marker", in_one(other_marker)),
    "drive gap": ("gap.drive", in_one(drive_gap)),
    "camera gap": ("gap.camera", in_one(camera_gap)),
    "clock jump": ("time.jump", in_one(clock_jump)),
    "no knock": ("knock.missing", in_one(no_knock, knocked)),
    "knock at 0.75 s": ("knock.wrong", everywhere(wrong_knock)),
    "cut start": ("start.moving", in_one(cut, steps)),
    "step labelled knock": ("label.kind", in_one(labelled("pseudo_impulse"), steps)),
    "step labelled motor_step": ("label.kind", in_one(labelled("motor_step"), steps)),
    "knock labelled step": ("label.kind", in_one(labelled("torque_step"), knocked)),
    "same run twice": ("label.duplicate", doubled),
    "before the limit": ("command.before_limit", everywhere(before_limit)),
    "nothing moves": ("excitation.none", in_one(still)),
    "start outside": ("pose.outside", in_one(lateral(17.3))),
    "voltage 2 in one run": ("sign.voltage_2", in_one(volts(-1, (1,)), steps)),
    "y downwards in one run": (
        "sign.y_e",
        in_one(
            MIRROR_Y, lambda c: [n for n in moving_runs(c) if n[:4] in ("0003", "0004", "0006")]
        ),
    ),
    "degrees in one run": ("unit.alpha", in_one(angles(1 / RAD))),
    "ms in one run": ("unit.time_camera", in_one(times(of_camera=1e3))),
    "offset in one run": ("clock.offset", in_one(times(shift=0.15))),
    "carriages in one run": (
        "swap.carriages",
        in_one(
            swap_carriages, lambda c: [n for n in moving_runs(c) if n[:4] in ("0001", "0002")]
        ),
    ),
}
"""Identifier and planting of each slip, by what it is."""


def counter(campaign: Campaign, random: np.random.Generator) -> Campaign:
    return each_run(campaign, wrapped(2**15 * 2 * math.pi / campaign.counts_per_rev))


PLANTED["wraps at 2^16"] = ("wrap.alpha", counter)


def counts(campaign: Campaign, random: np.random.Generator) -> Campaign:
    return each_run(campaign, angles(campaign.counts_per_rev / (2 * math.pi)))


def thinned(run: Run) -> Run:
    """The same run logged at 200 Hz."""
    every = max(1, round(5e-3 / float(run.drive.time[1] - run.drive.time[0])))
    rows = slice(None, None, every)
    d = run.drive
    return drive(run, time=d.time[rows], voltage=d.voltage[rows], angle=d.angle[rows])


def slow_jump(campaign: Campaign, random: np.random.Generator) -> Campaign:
    return in_one(jump(0.1))(each_run(campaign, thinned), random)


def constant_volts(run: Run) -> Run:
    voltage = run.drive.voltage.copy()
    voltage[:, 0] = 3.0
    return drive(run, voltage=voltage)


PLANTED |= {
    "counts labelled rad": ("unit.alpha", counts),
    "alpha 2 in one run": ("sign.alpha_2", in_one(angles(-1, (1,)))),
    "motor 1 in one run": (
        "sign.motor_1",
        in_one(chain(angles(-1, (0,)), volts(-1, (0,)))),
    ),
    "encoder 1 in degrees in one run": ("unit.alpha", in_one(angles(1 / RAD, (0,)))),
    "voltage 1 in one run": ("sign.voltage_1", in_one(volts(-1, (0,)), steps)),
    "mV in one run": ("unit.voltage", in_one(volts(1e3), steps)),
    "q_4 in cm as m": ("unit.position", everywhere(places(1e2, (Q4,)))),
    "jump of 0.1 rad at 200 Hz": ("jump.alpha", slow_jump),
    "volts stuck at 3": ("stuck.voltage", in_one(constant_volts, steps)),
}
"""Slips that the others imply: in one run only, of one encoder only, in slow logs."""


def applies(identifier: str, campaign: Campaign) -> bool:
    """Whether a slip of this kind is one in this campaign: nothing stated can't be wrong."""
    if identifier == "clock.offset":
        return campaign.runs[0].clock_offset is not None
    if identifier in ("knock.missing", "knock.wrong"):
        return any(run.knock is not None for run in campaign.runs)
    if identifier == "pose.outside":
        return any(run.initial is not None for run in campaign.runs)
    return True
