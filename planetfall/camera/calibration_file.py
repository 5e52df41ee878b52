"""Calibrations as YAML: the part of it that OpenCV's FileStorage and ROS's camera_info write.

YAML libraries stop at OpenCV's head (`%YAML:1.0`) and at its tags, so these few lines of grammar are read here.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..errors import CameraError

__all__ = ["read_calibration", "write_calibration"]

_ROS_NAMES = {
    "plumb_bob": "brown",
    "rational_polynomial": "rational",
    "thin_prism": "rational",
    "tilted": "rational",
    "equidistant": "fisheye",
    "kannala_brandt4": "fisheye",
}
_WRITTEN = {"pinhole": "plumb_bob", "brown": "plumb_bob", "rational": "rational_polynomial", "fisheye": "equidistant"}
_BY_COUNT = {0: "pinhole", 4: "brown", 5: "brown", 8: "rational", 12: "rational", 14: "rational"}
_LINE = re.compile(r"( *)([\w.\-]+|\"[^\"]*\")\s*:(?:\s+(.*))?$")
_PAIR = re.compile(r"([\w\-]+)\s*:\s*(\[[^\]]*\]|[^,\s}]+)")
"""Of what stands in braces on one line"""
_ENDS = {"[": "]", "{": "}"}
_MATRICES = ("camera_matrix", "distortion_coefficients")


def read_calibration(path: Path) -> dict[str, Any]:
    """Arguments of Intrinsics. CameraError for a file that can't be read or lacks something."""
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise CameraError(f"{path}: no such file (looked from {Path.cwd()}); check its name and folder") from None
    except (OSError, UnicodeDecodeError) as error:
        raise CameraError(f"{path}: can't be read as text: {error}") from error
    found = _values(path, text)
    numbers = {name: _numbers(path, name, found[name + ".data"]) for name in _MATRICES if name + ".data" in found}
    matrix, distortion = numbers.get("camera_matrix"), tuple(numbers.get("distortion_coefficients", ()))
    if matrix is None or len(matrix) != 9:
        raise CameraError(
            f"{path}: camera_matrix: expected a 3 x 3 matrix, nine numbers in data, found {matrix or 'none'}"
        )
    if matrix[1]:
        raise CameraError(f"{path}: camera_matrix: skew {matrix[1]:g} is not part of any model here; expected 0")
    told = found.get("distortion_model", "fisheye" if found.get("fisheye_model", "0") not in ("0", "") else "")
    model = _ROS_NAMES.get(told, told) or _BY_COUNT.get(len(distortion), "brown")
    if model == "brown" and not any(distortion):
        model, distortion = "pinhole", ()
    sides = {}
    for name in ("image_width", "image_height"):
        if not found.get(name, "").isdigit():
            raise CameraError(f"{path}: {name}: expected a whole number of pixels, found {found.get(name, 'nothing')}")
        sides[name.removeprefix("image_")] = int(found[name])
    focal = {"fx": matrix[0], "fy": matrix[4], "cx": matrix[2], "cy": matrix[5]}
    return {**sides, **focal, "distortion": distortion, "model": model}


def write_calibration(path: Path, told: Mapping[str, Any]) -> Path:
    """told: the fields of Intrinsics. Written beside, then renamed."""
    model, distortion = told["model"], told["distortion"]
    if model in ("pinhole", "brown") and not distortion:
        distortion = (0.0,) * 5
    elif model in ("rational", "fisheye") and not distortion:
        distortion = (0.0,) * (8 if model == "rational" else 4)
    fx, fy, cx, cy = (told[name] for name in ("fx", "fy", "cx", "cy"))
    lines = ["%YAML:1.0", "---", f"image_width: {told['width']}", f"image_height: {told['height']}"]
    lines += _matrix("camera_matrix", 3, (fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0))
    lines += [f"distortion_model: {_WRITTEN.get(model, model)}"]
    lines += _matrix("distortion_coefficients", 1, distortion) if distortion else []
    beside = path.with_name(f".{path.name}.tmp")
    try:
        beside.write_text("\n".join(lines) + "\n", encoding="utf-8")
        os.replace(beside, path)
    except OSError as error:
        beside.unlink(missing_ok=True)
        raise CameraError(
            f"{path}: can't be written: {error.strerror or error}; check its folder and rights"
        ) from error
    return path


def _matrix(name: str, rows: int, numbers: tuple[float, ...]) -> list[str]:
    head = [f"{name}: !!opencv-matrix", f"   rows: {rows}", f"   cols: {len(numbers) // rows}", "   dt: d"]
    return [*head, f"   data: [ {', '.join(repr(float(n)) for n in numbers)} ]"]


def _values(path: Path, text: str) -> dict[str, str]:
    """Scalars and lists as text by dotted keys, "camera_matrix.data"; a list may go on over lines."""
    found: dict[str, str] = {}
    above: list[tuple[int, str]] = []
    lines = iter(enumerate(text.splitlines(), 1))
    for number, raw in lines:
        line = raw.split(" #")[0].rstrip()
        if (item := line.strip()).startswith("- ") and above:  # a list with a line for each number
            name = ".".join(key for _, key in above)
            found[name] = f"{found[name]}, {item[2:]}" if name in found else item[2:]
            continue
        if not line.strip() or line.lstrip().startswith(("#", "%", "-", "...")):
            continue
        match = _LINE.match(line)
        if match is None:
            raise CameraError(f"{path}, line {number}: expected 'key: value', found {raw.strip()!r}")
        indent, key, value = len(match[1]), match[2].strip('"'), (match[3] or "").strip()
        above = [(depth, name) for depth, name in above if depth < indent]
        name = ".".join([*(name for _, name in above), key])
        while (end := _ENDS.get(value[:1], "")) not in value:
            more = next(lines, None)
            if more is None:
                raise CameraError(
                    f"{path}, line {number}: {key}: the list that begins there has no end, expected {end}"
                )
            value += " " + more[1].split(" #")[0].strip()
        if value.startswith("{"):
            found |= {f"{name}.{inner}": each for inner, each in _PAIR.findall(value)}
        elif value and not value.startswith("!"):
            found[name] = value.strip("\"'")
        else:
            above.append((indent, key))
    return found


def _numbers(path: Path, name: str, value: str) -> list[float]:
    try:
        return [float(part) for part in value.strip("[] ").split(",") if part.strip()]
    except ValueError:
        raise CameraError(f"{path}: {name}: data: expected a list of numbers, found {value[:60]!r}") from None
