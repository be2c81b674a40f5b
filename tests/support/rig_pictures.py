"""What a camera makes of light, and how its pictures are stored."""

import struct

import cv2
import numpy as np


def developed(camera, light, random):
    """A picture as it is stored, of the light on the sensor."""
    height, width = light.shape[:2]
    light = cv2.GaussianBlur(light, (0, 0), camera.blur)
    x, y = np.linspace(-1, 1, width), np.linspace(-1, 1, height)[:, None]
    light = (
        light * (camera.gain * (1 + 0.12 * x - 0.08 * y - 0.12 * (x * x + y * y)))[..., None]
    )
    raw = np.empty((height, width))
    raw[0::2, 0::2], raw[1::2, 1::2] = light[0::2, 0::2, 2], light[1::2, 1::2, 0]
    raw[0::2, 1::2], raw[1::2, 0::2] = light[0::2, 1::2, 1], light[1::2, 0::2, 1]
    if camera.noise:
        raw += random.normal(0, np.sqrt(np.maximum(raw, 0) / 20000 + 0.0012**2))
    raw = (np.clip(raw, 0, 1) * 65535).astype(np.uint16)
    colour = cv2.demosaicing(raw, cv2.COLOR_BayerRGGB2BGR) / 65535.0
    curved = np.where(colour <= 0.0031308, 12.92 * colour, 1.055 * colour ** (1 / 2.4) - 0.055)
    picture = np.clip(255 * curved + 0.5, 0, 255).astype(np.uint8)
    return np.ascontiguousarray(picture[::-1, ::-1]) if camera.upside_down else picture


def jpeg(picture, quality):
    settings = [
        cv2.IMWRITE_JPEG_QUALITY,
        quality,
        cv2.IMWRITE_JPEG_SAMPLING_FACTOR,
        cv2.IMWRITE_JPEG_SAMPLING_FACTOR_420,
    ]
    return cv2.imencode(".jpg", picture, settings)[1].tobytes()


def write_avi(path, pictures, size, rate):
    """Motion JPEG in a RIFF file, of pictures that are JPEG already."""

    def chunk(name, content):
        return name + struct.pack("<I", len(content)) + content + b"\0" * (len(content) % 2)

    width, height = size
    count = len(pictures)
    header = struct.pack(
        "<14I", int(1e6 / rate), 0, 0, 16, count, 0, 1, 0, width, height, 0, 0, 0, 0
    )
    stream = b"vidsMJPG" + struct.pack(
        "<I2H8I4H",
        0,
        0,
        0,
        0,
        1000,
        int(1000 * rate),
        0,
        count,
        1 << 20,
        0xFFFFFFFF,
        0,
        0,
        0,
        width,
        height,
    )
    form = struct.pack(
        "<I2i2H4sI4i", 40, width, height, 1, 24, b"MJPG", width * height * 3, 0, 0, 0, 0
    )
    lists = chunk(b"LIST", b"strl" + chunk(b"strh", stream) + chunk(b"strf", form))
    head = chunk(b"LIST", b"hdrl" + chunk(b"avih", header) + lists)
    movie, index, place = b"movi", b"", 4
    parts = [movie]
    for picture in pictures:
        part = chunk(b"00dc", picture)
        index += b"00dc" + struct.pack("<3I", 16, place, len(picture))
        parts.append(part)
        place += len(part)
    body = b"AVI " + head + chunk(b"LIST", b"".join(parts)) + chunk(b"idx1", index)
    path.write_bytes(chunk(b"RIFF", body))


def write_mp4(path, pictures, size, rate):
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"mp4v"), rate, size)
    for picture in pictures:
        writer.write(cv2.imdecode(np.frombuffer(picture, np.uint8), cv2.IMREAD_COLOR))
    writer.release()
