"""Files that mean harm, each with what reads it and a word of what is right to say."""

import dataclasses
import json
import os
import pathlib
import socket
import struct
import sys
import zlib
from collections.abc import Callable

import given_files
import h5py
import numpy as np

from identification.bring.campaign_import import mapped_campaign
from identification.bring.drive_log import import_drive_stream
from identification.campaign import read_campaign
from identification.vision.pictures.photos import read_photos
from identification.vision.pictures.stream import pictures


@dataclasses.dataclass(frozen=True)
class Hostile:
    """A file that is to be refused."""

    name: str
    """What it is."""
    make: Callable[[pathlib.Path], None]
    """Makes it, in a folder of good ones."""
    read: Callable[[pathlib.Path], object]
    """What reads it."""
    told: str
    """A part of the message."""


def _replaced(name, made):
    """Puts something in a file's place."""

    def make(folder):
        (folder / name).unlink()
        made(folder / name)

    return make


def _text(name, content):
    raw = content if isinstance(content, bytes) else content.encode()
    return lambda folder: (folder / name).write_bytes(raw)


def _changed(name, old, new):
    def make(folder):
        text = (folder / name).read_text(encoding="utf-8")
        assert old in text
        (folder / name).write_text(text.replace(old, new), encoding="utf-8")

    return make


def _socket(path):
    with socket.socket(socket.AF_UNIX) as own:
        before = os.getcwd()
        os.chdir(path.parent)  # a socket's name is short
        own.bind(path.name)
        os.chdir(before)


def _sparse(path):
    with path.open("wb") as file:
        file.truncate(2**31)


def _secret(path):
    secret = path.parents[2] / "secret"
    secret.write_text("root:x:0:0\n")
    path.symlink_to(secret)


def _linked_run(folder):
    (folder / "elsewhere").mkdir()
    (folder / "campaign" / "0003-linked").symlink_to(folder / "elsewhere")


def _run_called(name):
    def make(folder):
        source = os.fsencode(folder / "campaign" / "0001-step")
        os.rename(source, os.path.join(os.path.dirname(source), name))

    return make


def _deep_reference(path):
    """A cell of a MAT file of version 7.3 that holds itself."""
    with h5py.File(path, "w") as file:
        cell = file.create_dataset("log", (1, 1), dtype=h5py.ref_dtype)
        cell.attrs["MATLAB_class"] = np.bytes_("cell")
        cell[0, 0] = cell.ref


def _bomb(path, megabytes=400):
    """Half a megabyte of MAT file that unpacks to much more."""
    count = megabytes * 2**20 // 8
    packer = zlib.compressobj(1)
    flags = struct.pack("<IIII", 6, 8, 6, 0)
    head = struct.pack("<IIII", 5, 8, 1, count) + struct.pack("<HH4s", 1, 1, b"x\0\0\0")
    size = len(flags) + len(head) + 8 + 8 * count
    packed = [packer.compress(struct.pack("<II", 14, size) + flags + head)]
    packed.append(packer.compress(struct.pack("<II", 9, 8 * count)))
    packed += [packer.compress(bytes(2**20)) for _ in range(megabytes)]
    stream = b"".join([*packed, packer.flush()])
    header = b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack("<HH", 0x0100, 0x4D49)
    path.write_bytes(header + struct.pack("<II", 15, len(stream)) + stream)


def _large_picture(path):
    """A PNG that says it has ten thousand million pixels."""
    size = struct.pack(">II", 100_000, 100_000) + bytes([8, 2, 0, 0, 0])
    parts = b""
    for kind, content in (
        (b"IHDR", size),
        (b"IDAT", zlib.compress(bytes(1000))),
        (b"IEND", b""),
    ):
        parts += struct.pack(">I", len(content)) + kind + content
        parts += struct.pack(">I", zlib.crc32(kind + content))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + parts)


def _campaign(folder):
    return read_campaign(folder / "campaign")


def _mapping(folder):
    return mapped_campaign(folder / "mapping.toml")


def _log(name):
    return lambda folder: import_drive_stream(folder / name, columns={"voltage_1 [V]": "u"})


def _photo(folder):
    return list(read_photos([folder / "photo.png"]))


def _video(folder):
    with pictures(folder / "video.avi") as video:
        return list(video.frames)


_READ = {each.name: each.read for each in (*given_files.TEXTS, *given_files.RESULTS)}
_STEP = "campaign/0001-step"
_DRIVE, _CAMERA, _RUN = f"{_STEP}/drive.csv", f"{_STEP}/camera.csv", f"{_STEP}/run.toml"
_TOML = "campaign/campaign.toml"
_AXIS = "t [s],voltage [V],position [mm]\n0,0,0\n1,0,1\n2,0," + "9" * 200_000
_CELL = "a,b\n1," + "9" * 200_000 + "\n"


def _result(name, why, content, told):
    return Hostile(f"{name}: {why}", _text(name, content), _READ[name], told)


_LINKS = (
    Hostile("a pipe as a log", _replaced(_DRIVE, os.mkfifo), _campaign, "a pipe"),
    Hostile("a pipe as campaign.toml", _replaced(_TOML, os.mkfifo), _campaign, "a pipe"),
    Hostile("a folder as a log", _replaced(_CAMERA, os.mkdir), _campaign, "a folder"),
    Hostile("a socket as a log", _replaced(_DRIVE, _socket), _campaign, "a socket"),
    Hostile("two gigabytes", _replaced(_DRIVE, _sparse), _campaign, "64 MiB at most"),
    Hostile(
        "a link to a secret", _replaced(_CAMERA, _secret), _campaign, "out of the campaign"
    ),
    Hostile(
        "a link to a device",
        _replaced(_CAMERA, lambda path: path.symlink_to("/dev/zero")),
        _campaign,
        "out of the campaign",
    ),
    Hostile(
        "a link that leads nowhere",
        _replaced(_CAMERA, lambda path: path.symlink_to("gone.csv")),
        _campaign,
        "leads nowhere",
    ),
    Hostile("a run that is a link", _linked_run, _campaign, "out of the campaign"),
    Hostile("an escape in a run's name", _run_called(b"a\x1b[31m"), _campaign, r"a\x1b[31m"),
    Hostile("a line end in a run's name", _run_called(b"a\n0009 ok"), _campaign, r"a\n0009 ok"),
    Hostile(
        "a name that turns round", _run_called("a\u202eb".encode()), _campaign, r"a\u202eb"
    ),
    Hostile("a name that isn't UTF-8", _run_called(b"a\xff"), _campaign, r"a\udcff"),
)
_DOCUMENTS = (
    Hostile(
        "a quantity of 16,000 letters",
        _changed(_RUN, '"0.35 kN"', '"1 ' + "a" * 16_000 + '"'),
        _campaign,
        "16002 characters",
    ),
    Hostile(
        "a product of a thousand units",
        _changed(_RUN, '"0.35 kN"', '"1 N' + " N" * 1000 + '"'),
        _campaign,
        "2003 characters",
    ),
    Hostile(
        "a product of twenty units",
        _changed(_RUN, '"0.35 kN"', '"1 N' + " N" * 20 + '"'),
        _campaign,
        "is no unit",
    ),
    Hostile(
        "lists inside of each other", _text(_TOML, "x = " + "[" * 100_000), _campaign, "TOML"
    ),
    Hostile(
        "a key of 100,000 parts", _text(_TOML, "a." * 100_000 + "a = 1"), _campaign, "too many"
    ),
    Hostile(
        "a number of a million digits",
        _text(_TOML, "format = 0x" + "f" * 900_000),
        _campaign,
        "too long to print",
    ),
    Hostile(
        "a document of two megabytes", _text(_TOML, "#" * 2**21), _campaign, "1 MiB at most"
    ),
    Hostile(
        "a million keys", _text(_RUN, "".join(f"k{k}=1\n" for k in range(90_000))), _campaign,
        "the format isn't stated",
    ),
    Hostile(
        "40,000 unknown keys",
        _text(_RUN, "format = 1\n" + "".join(f"k{k}=1\n" for k in range(40_000))),
        _campaign,
        "more",
    ),
    Hostile("zero bytes", _text(_DRIVE, b"t [s]\0,\0"), _campaign, "a zero byte"),
    Hostile(
        "a cell of 200,000 digits",
        _text(_DRIVE, given_files.good_campaign.DRIVE + "9" * 200_000),
        _campaign,
        "field limit",
    ),
    Hostile(
        "a zero byte in a log's name",
        _changed("mapping.toml", '"log.csv"', '"log\\u0000.csv"'),
        _mapping,
        "zero byte",
    ),
    Hostile(
        "a device as a log", _changed("mapping.toml", '"log.csv"', '"/dev/zero"'), _mapping,
        "a device",
    ),
)  # fmt: skip
_RESULTS = (
    _result("frequencies.csv", "a cell of 200,000 digits", _CELL, "field limit"),
    _result("frequencies.csv", "not UTF-8", b"x [m]\xff", "the byte 0xff in row 1"),
    _result("plan.csv", "a cell of 200,000 digits", _CELL, "field limit"),
    _result("plan.csv", "not UTF-8", b"t [s]\n\xfe", "the byte 0xfe in row 2"),
    _result("legs.csv", "not UTF-8", b"\xff", "the byte 0xff"),
    _result("spectrum.csv", "a cell of 200,000 digits", _CELL, "field limit"),
    _result("axis.csv", "a cell of 200,000 digits", _AXIS, "field limit"),
    _result("stamps.csv", "a cell of 200,000 digits", _CELL, "field limit"),
    _result("parameters.json", "nested 100,000 times", "[" * 100_000, "nested too deeply"),
    _result("tuning.json", "a gain of 1e999", '{"controller": 1e999}', "tuning.json"),
    _result("tuning.json", "no text", bytes(range(256)), "tuning.json"),
    _result("codesign.json", "a key of a megabyte", json.dumps({"k" * 2**20: 1}), "codesign"),
)
_BINARY = (
    Hostile(
        "a MAT file that holds itself",
        _replaced("hdf5.mat", _deep_reference),
        _log("hdf5.mat"),
        "without end",
    ),
    Hostile("a MAT file that unpacks for ever", _replaced("level5.mat", _bomb),
            _log("level5.mat"), "damaged"),
    Hostile("a MAT file that is cut", _text("packed.mat", b"MATLAB 5.0" + b" " * 200),
            _log("packed.mat"), "damaged"),
    Hostile("a TDMS file of noise", _text("log.tdms", b"TDSm" + bytes(range(256)) * 9),
            _log("log.tdms"), "no channel"),
    Hostile("a photo of ten thousand megapixels",
            lambda folder: _large_picture(folder / "photo.png"), _photo, "no picture"),
    Hostile("a photo that is a pipe", lambda folder: os.mkfifo(folder / "photo.png"), _photo,
            "a pipe"),
    Hostile("a video of noise", _text("video.avi", b"RIFF" + bytes(range(256)) * 9), _video,
            "can't be read"),
    Hostile("a video that is a pipe", lambda folder: os.mkfifo(folder / "video.avi"), _video,
            "a pipe"),
)  # fmt: skip

HOSTILE = (*_LINKS, *_DOCUMENTS, *_RESULTS, *_BINARY)
"""Every one, where a system knows pipes, sockets and names that aren't UTF-8."""
KNOWN_HERE = sys.platform == "linux"
"""Whether this one does."""
