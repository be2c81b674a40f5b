"""A campaign as other programs would have logged it, in a style that is drawn."""

import dataclasses
import io

import h5py
import nptdms
import numpy as np
import scipy.io

from identification.campaign.types import encoder_resolution

STYLES = (
    "semicolons",
    "units in a row",
    "utf-16",
    "tabs and comments",
    "tdms",
    "mat arrays",
    "simulink",
    "mat 7.3",
)

NAMES = {
    "t": ("t", "Time", "Zeit", "X_Value", "time_stamp", "Elapsed"),
    "voltage": (("U1", "U2"), ("Cmd 1", "Cmd 2"), ("AO 0", "AO 1"), ("u_left", "u_right"),
                ("Motor1 Voltage", "Motor2 Voltage"), ("Spannung_A", "Spannung_B"),
                ("ctrl_volt1", "ctrl_volt2")),
    "alpha": (("Enc 0", "Enc 1"), ("alpha1", "alpha2"), ("Encoder Left", "Encoder Right"),
              ("ctr_1", "ctr_2"), ("Winkel_A", "Winkel_B"), ("motorAngle1", "motorAngle2"),
              ("Position 1", "Position 2")),
    "camera": (
        ("X", "Y", "theta", "lower", "upper"),
        ("ee_x", "ee_y", "ee_rot", "cart_low", "cart_high"),
        ("x_e", "y_e", "delta_e", "q_3", "q_4"),
        ("Effector X", "Effector Y", "Effector Angle", "q3", "q4"),
        ("pos_x", "pos_y", "rotation", "carriage_bottom", "carriage_top"),
        ("x", "y", "phi", "slider1", "slider2"),
    ),
    "extra": ("Temp", "spare", "Status", "loop_us", "Reserve 3"),
}  # fmt: skip
CAMERA = ("x_e", "y_e", "delta_e", "q_3", "q_4")
DRIVE = ("voltage_1", "voltage_2", "alpha_1", "alpha_2")
SI = {"t": "s", "voltage": "V", "alpha": "rad", "length": "m", "delta_e": "rad"}


@dataclasses.dataclass(frozen=True)
class Style:
    """How a campaign is written."""

    kind: str
    names: dict
    units: dict
    order: dict
    extra: tuple
    lost: object
    base: dict


def draw_style(kind, random, counts=True):
    """A style of a kind, with names, units and order at random."""
    pick = lambda options: options[random.integers(len(options))]  # noqa: E731
    volts, angles, camera = (pick(NAMES[key]) for key in ("voltage", "alpha", "camera"))
    names = {"t": pick(NAMES["t"]), "camera t": pick(NAMES["t"])}
    names |= dict(zip(DRIVE, (*volts, *angles), strict=True))
    names |= dict(zip(CAMERA, camera, strict=True))
    angle, length = (
        pick(("count", "rad", "deg") if counts else ("rad", "deg")),
        pick(("mm", "m", "cm")),
    )
    units = {"t": pick(("s", "ms")), "camera t": pick(("s", "ms"))}
    units |= dict.fromkeys(DRIVE[:2], pick(("V", "mV"))) | dict.fromkeys(DRIVE[2:], angle)
    units |= dict.fromkeys(CAMERA, length) | {"delta_e": pick(("rad", "deg"))}
    extra = tuple(random.choice(NAMES["extra"], random.integers(3), replace=False))
    order = {
        "drive": [int(k) for k in random.permutation(4 + len(extra))],
        "camera": [int(k) for k in random.permutation(5)],
    }
    base = {"zero": float(random.uniform(0, 50)), "lag": int(random.integers(1, 6))}
    return Style(kind, names, units, order, extra, pick((0, -1, "")), base)


def factor(unit, counts_per_rev):
    """SI units in one of a unit."""
    table = {"s": 1.0, "ms": 1e-3, "V": 1.0, "mV": 1e-3, "rad": 1.0, "deg": np.pi / 180,
             "m": 1.0, "cm": 1e-2, "mm": 1e-3}  # fmt: skip
    return table[unit] if unit in table else encoder_resolution(counts_per_rev)


def columns_of(run, style, counts_per_rev):
    """A run's drive and camera columns in the style's units, by the format's names."""
    drive = {"t": run.drive.time}
    for k, name in enumerate(DRIVE):
        drive[name] = (run.drive.voltage, run.drive.angle)[k // 2][:, k % 2]
    camera = {}
    if run.camera is not None:
        x, d, q3, q4, y = run.camera.position.T
        camera = {"camera t": run.camera.time}
        camera |= dict(zip(CAMERA, (x, y, d, q3, q4), strict=True))
    out = []
    for columns in (drive, camera):
        scaled = {n: _digits(v / factor(style.units[n], counts_per_rev), style.units[n])
                  for n, v in columns.items()}  # fmt: skip
        out.append(scaled)
    return out


def _digits(values, unit):
    return np.rint(values) if unit == "count" else values


def write_log(path, columns, style, random, table):
    """A text log of columns: names, units, dialect as the style has it."""
    kind = style.kind
    separator = {"semicolons": ";", "tabs and comments": "\t"}.get(kind, ",")
    if kind == "utf-16":
        separator = "\t"
    comma = kind == "semicolons"
    names = list(columns)
    order = [names[0], *(names[1 + k] for k in style.order[table] if 1 + k < len(names))]
    header = [style.names.get(n, n) for n in order]
    units = [style.units.get(n, "") for n in order]
    text = io.StringIO()
    if kind == "tabs and comments":
        text.write("# rig: planar robot; log of the controller\n# date\t2026-11-30\n")
    if kind == "units in a row":
        text.write(separator.join(f'"{h}"' for h in header) + "\n")
        text.write(separator.join(units) + "\n")
    else:
        brackets = {"semicolons": "{} [{}]", "utf-16": "{} ({})"}.get(kind, "{} [{}]")
        text.write(
            separator.join(brackets.format(h, u) if u else h
                           for h, u in zip(header, units, strict=True)) + "\n"
        )  # fmt: skip
    for k, row in enumerate(zip(*(columns[n] for n in order), strict=True)):
        cells = ["" if _lost(v) else (v if isinstance(v, str) else repr(float(v))) for v in row]
        if style.lost != "" and table == "camera":
            cells = [c or str(style.lost) for c in cells]
        if comma:
            cells = [c.replace(".", ",") for c in cells]
        text.write(separator.join(cells) + "\n")
        if kind == "tabs and comments" and k % 500 == 250:
            text.write("# marker set by the operator\n")
    encoding = {"utf-16": "utf-16", "semicolons": "utf-8-sig"}.get(kind, "utf-8")
    path.write_bytes(text.getvalue().encode(encoding))
    return path


def _lost(value):
    return not isinstance(value, str) and np.isnan(value)


def with_extra(columns, style, random):
    """Columns with some that nobody asked for."""
    rows = len(columns["t"])
    made = dict(columns)
    for name in style.extra:
        if name == "Status":
            made[name] = ["RUN"] * rows
        elif name == "loop_us":
            made[name] = np.round(random.normal(800, 9, rows), 1)
        else:
            made[name] = np.round(20 + np.cumsum(random.normal(0, 1e-3, rows)), 3)
    return made


def write_run(folder, run, style, random, counts_per_rev, stem):
    """A run's logs in the style; the drive's and the camera's files."""
    drive, camera = columns_of(run, style, counts_per_rev)
    if style.kind in STYLES[:4]:
        logs = [write_log(folder / f"{stem}_drive.csv", with_extra(drive, style, random), style,
                          random, "drive")]  # fmt: skip
        if camera:
            logs.append(write_log(folder / f"{stem}_cam.csv", camera, style, random, "camera"))
        return logs
    if style.kind == "tdms":
        return [_tdms(folder / f"{stem}.tdms", drive, camera, style, random)]
    camera = {n: np.where(np.isnan(v), _code(style), v) for n, v in camera.items()}
    if style.kind == "mat arrays":
        return [_arrays(folder / f"{stem}.mat", drive, camera, style)]
    if style.kind == "simulink":
        return _simulink(folder, stem, drive, camera, style)
    return [_hdf5(folder / f"{stem}.mat", drive, camera, style)]


def _code(style):
    return np.nan if style.lost == "" else float(style.lost)


def _tdms(path, drive, camera, style, random):
    """Each channel with its own clock: encoders begin earlier, and go on longer."""
    objects = []
    start = np.datetime64("2026-11-30T10:00:00")
    for group, columns in (("Rig", drive), ("Camera", camera)):
        if not columns:
            continue
        key = "t" if group == "Rig" else "camera t"
        time = columns[key] * factor(style.units[key], 1)
        even = np.ptp(np.diff(time)) < 1e-9
        for name, values in columns.items():
            if name == key and even:
                continue
            properties = {}
            values = np.where(np.isnan(values), _code(style), values)
            if even:
                step, lag = float(np.mean(np.diff(time))), 0
                if name.startswith("alpha"):
                    lag = style.base["lag"]
                    values = np.concatenate([np.full(lag, values[0]), values])
                properties = {
                    "wf_start_time": start,
                    "wf_start_offset": float(time[0]) - lag * step,
                    "wf_increment": step,
                    "wf_samples": len(values),
                }
            properties["unit_string"] = style.units[name]
            objects.append(nptdms.ChannelObject(group, style.names[name], values, properties))
    with nptdms.TdmsWriter(path) as writer:
        writer.write_segment(objects)
    return path


def _arrays(path, drive, camera, style):
    """Variables of MATLAB, some of them columns of an array."""
    contents = {
        _word(style.names["t"]): drive["t"][:, None],
        "u": np.stack([drive["voltage_1"], drive["voltage_2"]], axis=1),
        "enc": np.stack([drive["alpha_1"], drive["alpha_2"]], axis=1),
    }
    if camera:
        contents["cam_t"] = camera["camera t"][None, :]
        contents["cam"] = np.stack([camera[n] for n in CAMERA], axis=1)
    scipy.io.savemat(path, contents, do_compression=True)
    return path


def _simulink(folder, stem, drive, camera, style):
    paths = []
    for suffix, columns in (("drive", drive), ("cam", camera)):
        if not columns:
            continue
        (_, time), *rest = columns.items()
        signals = np.array(
            [(v[:, None], 1.0, style.names[n], style.units[n]) for n, v in rest],
            dtype=[("values", object), ("dimensions", object), ("label", object),
                   ("unit", object)],
        )  # fmt: skip
        path = folder / f"{stem}_{suffix}.mat"
        scipy.io.savemat(
            path, {"ScopeData": {"time": time[:, None], "signals": signals, "blockName": "m/S"}}
        )
        paths.append(path)
    return paths


def _hdf5(path, drive, camera, style):
    """Structures as MATLAB keeps them in HDF5: turned round, behind 512 bytes."""
    with h5py.File(path, "w", userblock_size=512) as file:
        logs = file.create_group("logs")
        logs.attrs["MATLAB_class"] = np.bytes_("struct")
        for group, columns in (("Rig", drive), ("Cam", camera)):
            if not columns:
                continue
            inner = logs.create_group(group)
            inner.attrs["MATLAB_class"] = np.bytes_("struct")
            for name, values in columns.items():
                made = inner.create_dataset(_word(style.names[name]), data=values[None, :])
                made.attrs["MATLAB_class"] = np.bytes_("double")
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")
    return path


def _word(name):
    return "".join(c if c.isalnum() else "_" for c in name)


def channel_name(style, name):
    """What a mapping calls a column."""
    label = style.names[name]
    if style.kind in STYLES[:4]:
        return label
    drive = name == "t" or name in DRIVE
    if style.kind == "tdms":
        return f"{'Rig' if drive else 'Camera'}/{label}"
    if style.kind == "mat 7.3":
        return f"logs.{'Rig' if drive else 'Cam'}.{_word(label)}"
    if style.kind == "simulink":
        if name in ("t", "camera t"):
            return "ScopeData.time"
        place = DRIVE.index(name) if drive else CAMERA.index(name)
        return f"ScopeData.signals({place + 1}).values"
    if name in ("t", "camera t"):
        return _word(label) if name == "t" else "cam_t"
    if drive:
        return f"{'u' if name.startswith('voltage') else 'enc'}(:,{name[-1]})"
    return f"cam[:, {CAMERA.index(name)}]"


def mapping_of(style, campaign, files, *, home, time_of):
    """The mapping that a careful person would write."""
    lines = ["format = 1", "[campaign]"]
    if campaign.counts_per_rev is not None:
        lines.append(f"counts_per_rev = {campaign.counts_per_rev:g}")
    for run, logs in zip(campaign.runs, files, strict=True):
        logs = [str(log.relative_to(home)) for log in logs]
        lines += [
            "[[run]]",
            f'name = "{run.name}"',
            f'kind = "{run.kind}"',
            f'pretension = "{run.pretension_label}"',
            f'drive_log = "{logs[0]}"',
        ]
        if run.camera is not None:
            lines.append(f'camera_log = "{logs[-1]}"')
        if run.initial is not None:
            lines += ["[run.initial]"] + [
                f'{key} = "{value!r} m"' for key, value in vars(run.initial).items()
            ]
        if run.knock is not None:
            lines += ["[run.knock]"] + [
                f'{key} = "{value!r} s"' for key, value in vars(run.knock).items()
            ]
        offset = "unknown" if run.clock_offset is None else f"{run.clock_offset!r} s"
        lines += ["[run.camera]", f'clock_offset = "{offset}"']
    for table, names in (("drive", ("t", *DRIVE)), ("camera", ("camera t", *CAMERA))):
        lines.append(f"[{table}.columns]")
        for name in names:
            if name.endswith("t") and not time_of[table]:
                continue
            lost = f", lost = [{style.lost}]" if table == "camera" and style.lost != "" else ""
            lost = "" if name == "camera t" else lost
            channel = channel_name(style, name)
            key = "t" if name == "camera t" else name
            lines.append(
                f'{key} = {{ channel = "{channel}", unit = "{style.units[name]}"{lost} }}'
            )
    return "\n".join(lines) + "\n"


def differences(campaign, other):
    """Largest differences of each stream [SI], over all runs."""
    worst = {}
    for run in campaign.runs:
        twin = other.run(run.name)
        pairs = [("time", run.drive.time, twin.drive.time),
                 ("voltage", run.drive.voltage, twin.drive.voltage),
                 ("angle", run.drive.angle - run.drive.angle[0],
                  twin.drive.angle - twin.drive.angle[0])]  # fmt: skip
        if run.camera is not None:
            pairs += [("frame time", run.camera.time, twin.camera.time),
                      ("position", run.camera.position, twin.camera.position)]  # fmt: skip
        for name, a, b in pairs:
            assert a.shape == b.shape, (run.name, name, a.shape, b.shape)
            assert np.array_equal(np.isnan(a), np.isnan(b)), (run.name, name)
            worst[name] = max(worst.get(name, 0.0), float(np.nanmax(np.abs(a - b))))
    return worst
