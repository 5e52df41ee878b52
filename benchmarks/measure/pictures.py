"""Tiles of pictures made up for benches, and frames beside one another in processor time."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

__all__ = ["first_tile", "processor_times", "write_pictures"]

_SIDE = 256


def first_tile(zoom: int, latitude_deg: float, longitude_deg: float) -> tuple[int, int]:
    """Column and row of the tile of a place."""
    y = np.arcsinh(np.tan(np.radians(latitude_deg))) / np.pi
    return int((longitude_deg / 360.0 + 0.5) * 2**zoom), int((0.5 - 0.5 * y) * 2**zoom)


def write_pictures(folder: Path, zoom: int, first: tuple[int, int], columns: int, rows: int) -> None:
    """JPEGs by zoom/x/y: fields of some hundred metres, grain of a pixel; each its own, the same every time."""
    for x in range(first[0], first[0] + columns):
        (folder / f"{zoom}/{x}").mkdir(parents=True, exist_ok=True)
        for y in range(first[1], first[1] + rows):
            Image.fromarray(_pixels(x, y)).save(folder / f"{zoom}/{x}/{y}.jpg", quality=90)


def _pixels(x: int, y: int) -> NDArray[np.uint8]:
    i, j = np.meshgrid(np.arange(_SIDE) + _SIDE * (x % 4096), np.arange(_SIDE) + _SIDE * (y % 4096))
    field = (i // 37 * 73 + j // 29 * 151) % 97 / 97.0
    grain = np.random.default_rng(x << 24 | y).normal(0.0, 9.0, (_SIDE, _SIDE))
    colour = np.stack([70.0 + 80.0 * field, 90.0 + 50.0 * field, 45.0 + 25.0 * field], axis=-1) + grain[..., None]
    return np.clip(colour, 0.0, 255.0).astype(np.uint8)


def processor_times(variants: Mapping[str, Callable[[], object]], runs: int, warm_up: int = 3) -> dict[str, float]:
    """Medians of the processor time of a call, milliseconds, of callables by turns: a busy machine changes all alike
    and hardly."""
    names = list(variants)
    taken: dict[str, list[float]] = {name: [] for name in names}
    for turn in range(-warm_up, runs):
        shift = turn % len(names)
        for name in names[shift:] + names[:shift]:
            used = time.process_time()
            variants[name]()
            if turn >= 0:
                taken[name].append(1e3 * (time.process_time() - used))
    return {name: float(np.median(ms)) for name, ms in taken.items()}
