"""EXR files: read back by a reader of the tests' own, and by OpenEXR's where it is installed."""

from __future__ import annotations

import json
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from planetfall.systems.capture import CaptureError, write_exr


def read(path: Path) -> tuple[dict[str, np.ndarray], dict[str, bytes]]:
    """By the format's description: attributes, then blocks of 16 lines, each undone as it says."""
    data = path.read_bytes()
    magic, version = struct.unpack_from("<ii", data)
    assert (magic, version & 0xFF) == (20000630, 2)
    at, attributes = 8, {}
    while data[at]:
        name, kind = (data[at:].split(b"\0", 2)[k].decode() for k in (0, 1))
        at += len(name) + len(kind) + 2
        (size,) = struct.unpack_from("<i", data, at)
        attributes[name] = data[at + 4 : at + 4 + size]
        at += 4 + size
    at += 1
    names = [entry for entry in split_channels(attributes["channels"])]
    x0, y0, x1, y1 = struct.unpack("<iiii", attributes["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    planes = {name: np.zeros((height, width), np.float32) for name in names}
    for (start,) in struct.iter_unpack("<Q", data[at : at + 8 * -(-height // 16)]):
        first, size = struct.unpack_from("<ii", data, start)
        lines = min(16, height - first)
        block, whole = data[start + 8 : start + 8 + size], lines * width * 4 * len(names)
        if size < whole:
            packed = bytearray(zlib.decompress(block))
            for k in range(1, len(packed)):
                packed[k] = (packed[k - 1] + packed[k] - 128) % 256
            half = (len(packed) + 1) // 2
            block = bytearray(whole)
            block[0::2], block[1::2] = packed[:half], packed[half:]
        values = np.frombuffer(bytes(block), "<f4").reshape(lines, len(names), width)
        for number, name in enumerate(names):
            planes[name][first : first + lines] = values[:, number]
    return planes, attributes


def split_channels(listed: bytes) -> list[str]:
    names = []
    while listed[0]:
        name, _, rest = listed.partition(b"\0")
        assert struct.unpack_from("<i", rest) == (2,)  # 32-bit float
        names.append(name.decode())
        listed = rest[16:]
    return names


def some(height: int, width: int) -> dict[str, np.ndarray]:
    draw = np.random.default_rng(3)
    smooth = np.linspace(0.0, 1.0, width, dtype=np.float32)[None] * np.ones((height, 1), np.float32)
    noise = draw.normal(size=(height, width)).astype(np.float32) * 1e4
    odd = noise.copy()
    odd.flat[:3] = (np.inf, -np.inf, np.nan)
    return {"R": smooth, "G": noise, "B": np.zeros_like(smooth), "distance.Z": odd}


@pytest.mark.parametrize("size", [(1, 1), (16, 5), (17, 3), (50, 33)])
def test_every_bit_comes_back(tmp_path: Path, size: tuple[int, int]) -> None:
    channels = some(*size)
    path = write_exr(tmp_path / "a.exr", channels, {"seed": 7, "place": np.arange(2)})
    planes, attributes = read(path)
    assert list(planes) == sorted(channels)
    for name, plane in channels.items():
        assert plane.tobytes() == planes[name].tobytes(), name
    assert json.loads(attributes["planetfall"]) == {"seed": 7, "place": [0, 1]}


def test_another_reader_agrees(tmp_path: Path) -> None:
    exr: Any = pytest.importorskip("OpenEXR")
    channels = some(50, 33)
    path = write_exr(tmp_path / "a.exr", channels)
    with exr.File(str(path), separate_channels=True) as file:
        for name, plane in channels.items():
            assert np.array_equal(file.channels()[name].pixels, plane, equal_nan=True), name


def test_what_cannot_be_written(tmp_path: Path) -> None:
    with pytest.raises(CaptureError, match="at least one channel"):
        write_exr(tmp_path / "a.exr", {})
    with pytest.raises(CaptureError, match=r"'b' has shape \(2, 3\), expected \(H, W\) as \(3, 2\)"):
        write_exr(tmp_path / "a.exr", {"a": np.zeros((3, 2)), "b": np.zeros((2, 3))})
    assert list(tmp_path.iterdir()) == []
