"""OpenEXR files: radiance and other arrays in 32 bits for compositing programs.

Written by the file format's own description (openexr.com, "OpenEXR File Layout"): one part, scan lines, 32-bit floats,
ZIP compression of blocks of 16 lines with its byte predictor. No library is needed for that.
"""

from __future__ import annotations

import json
import struct
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from .files import CaptureError, written_beside
from .png import KEY, json_plain

__all__ = ["read_exr_settings", "write_exr"]

_MAGIC, _VERSION = 20000630, 2
_FLOAT, _ZIP, _LINES = 2, 3, 16


def write_exr(
    path: Path | str,
    channels: Mapping[str, NDArray[Any]],
    settings: Mapping[str, Any] | None = None,
    wavelengths_nm: tuple[float, float, float] | None = None,
) -> Path:
    """Write channels {"R": (H, W), "normal.X": (H, W), ...}, row 0 on top, as 32-bit floats.

    Names before a dot are layers. settings: JSON in the header's attribute "planetfall". wavelengths_nm: of R, G and
    B, in an attribute of that name. Raises CaptureError for arrays of other shapes or none at all.
    """
    path = Path(path)
    if not channels:
        raise CaptureError(f"{path}: an EXR file needs at least one channel, found none")
    names = sorted(channels)
    planes = [np.ascontiguousarray(channels[name], "<f4") for name in names]
    shape = planes[0].shape
    wrong = next((n for n, plane in zip(names, planes, strict=True) if plane.ndim != 2 or plane.shape != shape), None)
    if wrong is not None:
        raise CaptureError(f"{path}: channel {wrong!r} has shape {channels[wrong].shape}, expected (H, W) as {shape}")
    height, width = shape
    header = struct.pack("<ii", _MAGIC, _VERSION | (0x400 if max(map(len, names)) > 31 else 0))
    listed = b"".join(n.encode() + b"\0" + struct.pack("<iB3xii", _FLOAT, 0, 1, 1) for n in names) + b"\0"
    box = struct.pack("<iiii", 0, 0, width - 1, height - 1)
    attributes = [
        ("channels", "chlist", listed),
        ("compression", "compression", bytes([_ZIP])),
        ("dataWindow", "box2i", box),
        ("displayWindow", "box2i", box),
        ("lineOrder", "lineOrder", b"\0"),
        ("pixelAspectRatio", "float", struct.pack("<f", 1.0)),
        ("screenWindowCenter", "v2f", struct.pack("<ff", 0.0, 0.0)),
        ("screenWindowWidth", "float", struct.pack("<f", 1.0)),
    ]
    if wavelengths_nm is not None:
        attributes.append(("wavelengths_nm", "v3f", struct.pack("<fff", *wavelengths_nm)))
    if settings is not None:
        attributes.append((KEY, "string", json.dumps(settings, default=json_plain, ensure_ascii=False).encode()))
    for name, kind, value in attributes:
        header += name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value
    header += b"\0"
    blocks = [_block(planes, first, min(first + _LINES, height)) for first in range(0, height, _LINES)]
    offset = len(header) + 8 * len(blocks)
    with written_beside(path) as beside, beside.open("wb") as file:
        file.write(header)
        for block in blocks:
            file.write(struct.pack("<Q", offset))
            offset += len(block)
        file.writelines(blocks)
    return path


def read_exr_settings(path: Path | str) -> dict[str, Any]:
    """The settings inside an EXR file of ours. Raises CaptureError when there are none."""
    path = Path(path)
    try:
        with path.open("rb") as file:
            magic, _version = struct.unpack("<ii", file.read(8))
            if magic != _MAGIC:
                raise CaptureError(f"{path} cannot be read as a picture: it is no OpenEXR file")
            while name := _text(file):
                _text(file)  # the attribute's type
                (size,) = struct.unpack("<i", file.read(4))
                value = file.read(max(size, 0))
                if name == KEY:
                    return json.loads(value.decode())
    except (OSError, struct.error, ValueError) as error:
        raise CaptureError(f"{path} cannot be read as an OpenEXR file: {error}") from error
    raise CaptureError(f"{path} carries no Planetfall settings; only pictures written by Planetfall do")


def _text(file: BinaryIO) -> str:
    """A text that ends with a zero byte; at most 255 bytes, as the format allows."""
    found = b""
    while (byte := file.read(1)) != b"\0":
        found += byte
        if not byte or len(found) > 255:
            raise ValueError("its header ends in the middle of a name")
    return found.decode()


def _block(planes: list[NDArray[np.float32]], first: int, end: int) -> bytes:
    """Lines first..end, channel by channel in each line."""
    raw = np.concatenate([plane[first:end, None, :] for plane in planes], axis=1).tobytes()
    data = np.frombuffer(raw, np.uint8)
    # The format's predictor: even bytes, then odd ones, each as its difference to the one before, plus 128.
    parted = np.concatenate([data[0::2], data[1::2]]).astype(np.int16)
    parted[1:] = (parted[1:] - parted[:-1] + 128) & 255
    packed = zlib.compress(parted.astype(np.uint8).tobytes(), 4)
    if len(packed) >= len(raw):
        packed = raw
    return struct.pack("<ii", first, len(packed)) + packed
