"""Tiles of elevation made up for benches: SRTM files of a field in closed form, and empty ones by the thousand."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

__all__ = ["hgt_heights", "write_empty", "write_repeated", "write_tiles"]


def hgt_heights(south: int, west: int, side: int) -> NDArray[np.int16]:
    """Whole metres (side, side) of a tile of one degree: ranges of 20 km, hills of 2 km, rough ground."""
    at = np.arange(side) / (side - 1)
    x, y = np.meshgrid(west + at, south + 1.0 - at)
    rough = np.random.default_rng(south * 360 + west).normal(0.0, 4.0, (side, side))
    rough[[0, -1], :] = rough[:, [0, -1]] = 0.0  # neighbours share their border
    ranges = 800.0 * np.sin(18.0 * x + 7.0 * np.sin(3.0 * y)) + 150.0 * np.sin(180.0 * x) * np.sin(150.0 * y)
    return np.rint(1500.0 + ranges + rough).astype(np.int16)


def write_tiles(folder: Path, south: int, west: int, rows: int, columns: int, side: int) -> None:
    """rows x columns tiles of one degree north of the equator and east of Greenwich."""
    folder.mkdir(parents=True, exist_ok=True)
    for j in range(rows):
        for i in range(columns):
            heights = hgt_heights(south + j, west + i, side)
            heights.astype(">i2").tofile(folder / f"N{south + j:02d}E{west + i:03d}.hgt")


def write_repeated(folder: Path, south: int, west: int, rows: int, columns: int) -> None:
    """rows x columns tiles of one degree and 1 arc second that are one file under many names: what it has at one border
    goes on at the other."""
    folder.mkdir(parents=True, exist_ok=True)
    at = 2.0 * np.pi * np.arange(3600) / 3600.0
    x, y = np.meshgrid(at, at)
    heights = 1200.0 + 400.0 * np.sin(3.0 * x + np.sin(2.0 * y)) * np.cos(4.0 * y) + 90.0 * np.sin(31.0 * x - 17.0 * y)
    heights += 25.0 * np.sin(140.0 * y + 60.0 * x) + np.random.default_rng(0).normal(0.0, 1.5, heights.shape)
    first: Path | None = None
    for j in range(rows):
        for i in range(columns):
            path = folder / f"N{south + j:02d}E{west + i:03d}.hgt"
            if first is None:
                np.rint(np.pad(heights, ((0, 1), (0, 1)), mode="wrap")).astype(">i2").tofile(path)
                first = path
            else:
                os.link(first, path)


def write_empty(folder: Path, count: int) -> None:
    """Files of four samples, a thousand a folder; several stand for the same degree."""
    for k in range(count):
        inside = folder / str(k // 1000)
        if k % 1000 == 0:
            inside.mkdir(parents=True, exist_ok=True)
        (inside / f"N{k % 80:02d}E{k // 80 % 180:03d}_{k}.hgt").write_bytes(b"\0" * 8)
