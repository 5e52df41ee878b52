"""Captures: pictures and arrays of a frame as files, PNG, EXR or npz by the file's name, with their settings inside."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..engine.settings import did_you_mean
from ..engine.srgb import SRGB_STEPS
from ..errors import OutputError
from ..render.outputs import OUTPUTS
from ..systems.capture import read_arrays, read_exr_settings, read_png_settings, write_arrays, write_exr, write_png

__all__ = [
    "ARRAYS", "SUFFIXES", "check_arrays", "check_suffix", "exr_channels", "outputs_for", "read_settings",
    "save_capture",
]  # fmt: skip

ARRAYS = ("color", "radiance", "distance", "position", "normal", "surface")
"""What files of arrays hold of a frame; see Renderer.render."""
SUFFIXES = (".png", ".exr", ".npz")

LARGEST_ARRAYS_PX = 2**26
"""Of a file of arrays: all of it is in memory at once, 44 bytes a pixel and as much again while it is written."""

_NO_INSTANCE = "an EXR's channels are floats, which cannot hold the numbers of 'instance': write a .npz"
_AXES = ("X", "Y", "Z")


def check_suffix(path: str | PathLike[str], what: str = "output") -> Path:
    """The path, if its name says which kind of file it is to be; OutputError otherwise."""
    path = Path(path)
    if path.suffix.lower() not in SUFFIXES:
        raise OutputError(f"{what}: expected a name ending in .png, .exr or .npz, found {str(path)!r}")
    return path


def outputs_for(path: Path, names: Sequence[str] = ()) -> tuple[str, ...]:
    """What has to be rendered for such a file: the picture, or arrays, those of ARRAYS unless `names` says which.
    OutputError for a name that the file can't hold, or that a single picture hasn't."""
    picture = path.suffix.lower() == ".png"
    for name in names:
        if name not in OUTPUTS:
            raise OutputError(f"outputs: no output {name!r}; {did_you_mean(name, OUTPUTS, 'outputs')}")
        if name == "flow":
            raise OutputError(
                "outputs: flow leads to the frame before, and a single picture has none; see docs/labels.md"
            )
        if picture and name != "color":
            raise OutputError(f"{path}: a PNG takes color alone, found {name!r} in outputs; write a .npz or .exr")
    if path.suffix.lower() == ".exr" and "instance" in names:
        raise OutputError(_NO_INSTANCE)
    return tuple(dict.fromkeys(names)) or (("color",) if picture else ARRAYS)


def check_arrays(path: Path, size: tuple[int, int]) -> None:
    """OutputError where a file of arrays would be too large to be in memory. PNGs have other limits."""
    width, height = size
    if path.suffix.lower() != ".png" and width * height > LARGEST_ARRAYS_PX:
        raise OutputError(
            f"{path}: arrays of {width} x {height} pixels are {44 * width * height / 2**30:.1f} GiB, which are in"
            f" memory at once; expected at most {LARGEST_ARRAYS_PX // 2**20} million pixels. Lower the size, or write"
            " a .png"
        )


def save_capture(
    path: str | PathLike[str], arrays: Mapping[str, NDArray[Any]], settings: Mapping[str, Any] | None = None
) -> Path:
    """Write what Renderer.render returned; written beside and renamed.

    path: .png takes "color" alone; .npz takes every array under its own name, and "camera", "exposure" and
    "wavelengths_nm" of the settings as camera_<name>, exposure and wavelengths_nm; .exr takes them as channels, see
    `exr_channels`, and the wavelengths as an attribute. settings: plain data that the file carries, such as
    `shot_settings` gives. Raises OutputError for another kind of file, CaptureError for a
    file that can't be written.
    """
    path = check_suffix(path)
    kind = path.suffix.lower()
    if kind == ".png":
        if "color" not in arrays:
            raise OutputError(f"{path}: a PNG takes the array 'color', found {', '.join(arrays) or 'none'}")
        return write_png(path, arrays["color"], settings)
    told = settings or {}
    nm = told.get("wavelengths_nm") if "radiance" in arrays else None
    if kind == ".exr":
        return write_exr(path, exr_channels(arrays), settings, nm)
    camera, exposure = _numbers(told.get("camera", {})), told.get("exposure")
    return write_arrays(path, arrays, camera=camera, exposure=exposure, settings=told, wavelengths_nm=nm)


def exr_channels(arrays: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[np.float32]]:
    """Arrays as channels by EXR's customs: scene-linear light in R, G, B, and distances from the viewer in Z.

    radiance: R, G, B (W m^-2 sr^-1 nm^-1 at the attribute wavelengths_nm, before exposure). distance: Z (m, inf for the
    sky). color: color.R, .G, .B, the exposed picture in linear light, 0..1. position, normal, flow: position.X and so
    on. surface: surface. Others: their name, or name.R and so on. OutputError for instance, whose numbers of 32 bits a
    float cannot hold.
    """
    if "instance" in arrays:
        raise OutputError(_NO_INSTANCE)
    channels: dict[str, NDArray[Any]] = {}
    for name, array in arrays.items():
        if name == "radiance":
            channels.update(zip("RGB", np.moveaxis(array, -1, 0), strict=True))
        elif name == "distance":
            channels["Z"] = array
        elif name == "color":
            for k, letter in enumerate("RGB"):
                channels[f"color.{letter}"] = SRGB_STEPS[array[..., k]]
        elif array.ndim == 2:
            channels[name] = array
        else:
            letters = _AXES if name in ("position", "normal", "flow") else "RGBA"
            channels.update({f"{name}.{letters[k]}": array[..., k] for k in range(array.shape[2])})
    return {name: np.asarray(channel, np.float32) for name, channel in channels.items()}


def read_settings(path: str | PathLike[str]) -> dict[str, Any]:
    """The settings inside a PNG, EXR or npz of ours. CaptureError where there are none."""
    path = Path(path)
    kind = path.suffix.lower()
    if kind == ".npz":
        return read_arrays(path)[1]
    return read_exr_settings(path) if kind == ".exr" else read_png_settings(path)


def _numbers(state: Mapping[str, Any]) -> dict[str, Any]:
    """Those camera settings that are numbers."""
    return {name: value for name, value in state.items() if np.issubdtype(np.asarray(value).dtype, np.number)}
