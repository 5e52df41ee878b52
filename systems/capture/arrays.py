"""npz files: all outputs of a render with camera, exposure and settings, for other programs to measure."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .files import CaptureError, written_beside
from .png import json_plain

SETTINGS = "settings_json"


def write_arrays(
    path: Path | str,
    outputs: Mapping[str, NDArray[Any]],
    *,
    camera: Mapping[str, ArrayLike] | None = None,
    exposure: float | None = None,
    settings: Mapping[str, Any] | None = None,
    wavelengths_nm: ArrayLike | None = None,
) -> Path:
    """Write ``outputs`` by name, ``camera`` as ``camera_<name>`` (f64), ``exposure``, ``wavelengths_nm`` of radiance
    and JSON ``settings``."""
    path = Path(path)
    arrays: dict[str, Any] = dict(outputs)
    for name, value in (camera or {}).items():
        arrays[f"camera_{name}"] = np.asarray(value, dtype=np.float64)
    if exposure is not None:
        arrays["exposure"] = np.float64(exposure)
    if wavelengths_nm is not None:
        arrays["wavelengths_nm"] = np.asarray(wavelengths_nm, dtype=np.float64)
    arrays[SETTINGS] = np.array(json.dumps(settings or {}, default=json_plain, ensure_ascii=False))
    with written_beside(path) as beside, beside.open("wb") as file:
        np.savez_compressed(file, **arrays)
    return path


def read_arrays(path: Path | str) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
    """The arrays of a file of ours by name, and its settings."""
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
    except (OSError, ValueError) as error:
        raise CaptureError(f"{path} cannot be read as arrays: {error}") from error
    if SETTINGS not in arrays:
        raise CaptureError(f"{path} carries no Planetfall settings; only arrays written by Planetfall do")
    return arrays, json.loads(str(arrays.pop(SETTINGS)))
