"""Slips as changes of one run: what a wrong unit, plug, sign or logger makes of it."""

import dataclasses
import math
from collections.abc import Callable, Sequence

import numpy as np

from identification.campaign import Run

X, D, Q3, Q4, Y = range(5)
HEIGHT, WIDTH = 1.112, 2.224
RAD = math.pi / 180

Change = Callable[[Run], Run]


def drive(run: Run, **columns: np.ndarray) -> Run:
    return dataclasses.replace(run, drive=dataclasses.replace(run.drive, **columns))


def camera(run: Run, **columns: np.ndarray) -> Run:
    if run.camera is None:
        return run
    return dataclasses.replace(run, camera=dataclasses.replace(run.camera, **columns))


def angles(factor: float, columns: Sequence[int] = (0, 1)) -> Change:
    def change(run: Run) -> Run:
        angle = run.drive.angle.copy()
        angle[:, columns] *= factor
        return drive(run, angle=angle)

    return change


def volts(factor: float, columns: Sequence[int] = (0, 1)) -> Change:
    def change(run: Run) -> Run:
        voltage = run.drive.voltage.copy()
        voltage[:, columns] *= factor
        return drive(run, voltage=voltage)

    return change


def places(
    factor: float, columns: Sequence[int] = (X, Q3, Q4, Y), shift: float = 0.0
) -> Change:
    def change(run: Run) -> Run:
        if run.camera is None:
            return run
        position = run.camera.position.copy()
        position[:, columns] = shift + factor * position[:, columns]
        return camera(run, position=position)

    return change


def times(*, of_drive: float = 1.0, of_camera: float = 1.0, shift: float = 0.0) -> Change:
    def change(run: Run) -> Run:
        run = drive(run, time=run.drive.time * of_drive)
        if run.camera is None:
            return run
        return camera(run, time=run.camera.time * of_camera + shift)

    return change


def chain(*changes: Change) -> Change:
    def change(run: Run) -> Run:
        for one in changes:
            run = one(run)
        return run

    return change


def swap(signal: str) -> Change:
    def change(run: Run) -> Run:
        return drive(run, **{signal: getattr(run.drive, signal)[:, ::-1]})

    return change


def swap_carriages(run: Run) -> Run:
    if run.camera is None:
        return run
    return camera(run, position=run.camera.position[:, [X, D, Q4, Q3, Y]])


def wrapped(period: float) -> Change:
    def change(run: Run) -> Run:
        return drive(run, angle=np.mod(run.drive.angle, period))

    return change


def before_limit(run: Run) -> Run:
    """A controller that asked for more than the amplifier gives."""
    voltage = run.drive.voltage
    largest = np.abs(voltage).max()
    asked = np.where(np.abs(voltage) >= 0.999 * largest, 1.6 * 10.0 * np.sign(voltage), voltage)
    return drive(run, voltage=asked) if largest > 7 else run


def jump(size: float) -> Change:
    def change(run: Run) -> Run:
        angle = run.drive.angle.copy()
        angle[int(0.4 * len(angle)) :, 0] += size
        return drive(run, angle=angle)

    return change


def stuck_angle(run: Run) -> Run:
    angle = run.drive.angle.copy()
    first = int(0.15 * len(angle))
    angle[first:, 1] = angle[first, 1]
    return drive(run, angle=angle)


def stuck_volts(run: Run) -> Run:
    voltage = run.drive.voltage.copy()
    voltage[:, 0] = 0.0
    return drive(run, voltage=voltage)


def stuck_place(column: int) -> Change:
    def change(run: Run) -> Run:
        position = run.camera.position.copy()
        first = len(position) // 3
        value = position[first:, column]
        position[first:, column] = value[np.isfinite(value)][0]
        return camera(run, position=position)

    return change


def lost(code: float) -> Change:
    def change(run: Run) -> Run:
        position = run.camera.position.copy()
        position[[12, 20, 33]] = code
        return camera(run, position=position)

    return change


def last_value(run: Run) -> Run:
    position = run.camera.position.copy()
    for row in (12, 20, 33):
        position[row] = position[row - 1]
    return camera(run, position=position)


def other_marker(run: Run) -> Run:
    position = run.camera.position.copy()
    position[25, [X, Y]] += 0.06, 0.09
    return camera(run, position=position)


def drive_gap(run: Run) -> Run:
    rows = len(run.drive.time)
    keep = np.r_[0 : rows // 2, rows // 2 + rows // 12 : rows]
    return kept(run, keep)


def kept(run: Run, rows: np.ndarray) -> Run:
    """The run with some of its drive's rows: every column that it has."""
    return drive(
        run,
        **{
            field.name: column[rows]
            for field in dataclasses.fields(run.drive)
            if isinstance(column := getattr(run.drive, field.name), np.ndarray)
        },
    )


def camera_gap(run: Run) -> Run:
    keep = np.r_[0:30, 42 : len(run.camera.time)]
    return camera(run, time=run.camera.time[keep], position=run.camera.position[keep])


def clock_jump(run: Run) -> Run:
    time = run.drive.time.copy()
    time[len(time) // 2 :] += 7200.0
    return drive(run, time=time)


def no_knock(run: Run) -> Run:
    return dataclasses.replace(run, knock=None)


def wrong_knock(run: Run) -> Run:
    knock = dataclasses.replace(run.knock, start=0.75) if run.knock else None
    return dataclasses.replace(run, knock=knock)


def cut(run: Run) -> Run:
    """The logger was started late."""
    d, c = run.drive, run.camera
    begin = 0.6
    late, seen = d.time >= begin, c.time >= begin
    run = drive(kept(run, late), time=d.time[late] - begin)
    run = camera(run, time=c.time[seen] - begin, position=c.position[seen])
    return dataclasses.replace(run, initial=None)


def labelled(kind: str) -> Change:
    return lambda run: dataclasses.replace(run, kind=kind, knock=None)


def still(run: Run) -> Run:
    run = drive(run, voltage=0 * run.drive.voltage, angle=0 * run.drive.angle)
    noise = np.random.default_rng(1).normal(0, 1.9e-4, run.camera.position.shape)
    return camera(run, position=run.camera.position[:1] + noise)


def lateral(offset: float) -> Change:
    return lambda run: dataclasses.replace(
        run, initial=dataclasses.replace(run.initial, x_e=offset) if run.initial else None
    )
