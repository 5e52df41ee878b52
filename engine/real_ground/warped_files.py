"""Heights and colours of GeoTIFFs in other coordinate systems, at the samples of the lattice that was chosen for them;
next to a border with the pixels of the files beside."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .found import Found, TileError
from .geo_system import system_of
from .geo_tags import GeoHeader, geo_header
from .tiff_parts import tiff_parts
from .tile_numbers import believed, plain_heights
from .warp import warped, within

__all__ = ["FileGrid", "file_grid", "in_file", "pixel_shift", "warped_colors", "warped_heights"]

Floats = NDArray[np.float64]
Colors = NDArray[np.uint8]
OfFile = Callable[[Path, slice, slice], Floats]
"""Values (channels, rows, columns) of a part of a file, NaN where there is none."""

_SAME = 0.02
"""Of a pixel, that grids of two files may differ by."""


def warped_heights(file: Path, found: Found) -> NDArray[np.float64]:
    """Metres (rows, columns) of a window of a lattice, NaN where there is none. TileError says what is wrong."""
    header = geo_header(file)
    pixels = _with_beside(file, header, found, _heights_part)
    return warped(found, header, system_of(file, header), pixels)[0].astype(np.float64)


def warped_colors(file: Path, found: Found, four: Callable[[NDArray[Any]], Colors]) -> Colors:
    """As read_color_tile, of a window of a lattice. four: makes of a file's pixels (rows, columns, samples) red, green,
    blue and whether there is one."""
    header = geo_header(file)
    pixels = _with_beside(file, header, found, partial(_colors_part, four=four))
    values = warped(found, header, system_of(file, header), pixels, 3, 0.0)
    there = ~np.isnan(values[0])
    out = np.zeros((found.rows, found.columns, 4), np.uint8)
    out[..., :3] = np.rint(np.where(there, values, 0.0)).transpose(1, 2, 0)
    out[..., 3] = np.where(there, 255, 0)
    return out


def in_file(file: Path, found: Found) -> NDArray[np.bool_]:
    """Which samples (rows, columns) of a tile lie within its file's pixels."""
    if not found.warped:
        return np.ones((found.rows, found.columns), bool)
    header = geo_header(file)
    return within(found, header, system_of(file, header))


@dataclass(frozen=True)
class FileGrid:
    """A file's coordinate system, in words, and its place (column, row, columns, rows) on the grid of pixels, named by
    `key`, that it shares with others."""

    label: str
    note: str
    key: object
    place: tuple[int, int, int, int]


def file_grid(file: Path) -> FileGrid:
    """What a file's header says. TileError says what is wrong."""
    header = geo_header(file)
    system = system_of(file, header)
    x, y = (float(v) for v in header.model(0.5 * header.columns, 0.5 * header.rows))
    accuracy_m = system.accuracy_m(x, y)
    note = f"{system.name}, known to {accuracy_m:.2g} m" if accuracy_m else system.name
    a, b, c, d, e, f = header.matrix
    column, row = np.rint(np.linalg.solve([[a, b], [d, e]], [c, f])).astype(int).tolist()
    steps = tuple(float(f"{v:.6g}") for v in (a, b, d, e))
    return FileGrid(system.label, note, (header.keys, steps), (column, row, header.columns, header.rows))


def pixel_shift(header: GeoHeader, other: GeoHeader) -> tuple[int, int] | None:
    """How many columns and rows the first pixel of `other` is from that of `header`; None where their pixels don't lie
    on one grid."""
    if header.keys != other.keys or not np.allclose(header.matrix[:2], other.matrix[:2], rtol=1e-6, atol=0.0):
        return None
    if not np.allclose(header.matrix[3:5], other.matrix[3:5], rtol=1e-6, atol=0.0):
        return None
    at = np.array(header.pixel(other.matrix[2], other.matrix[5]))
    whole = np.rint(at)
    return (int(whole[0]), int(whole[1])) if np.abs(at - whole).max() < _SAME else None


def _heights_part(file: Path, rows: slice, columns: slice) -> Floats:
    values = tiff_parts(file).part(rows, columns)
    if values.shape[2] != 1:
        raise TileError(f"{file} has {values.shape[2]} channels; expected one: heights in metres")
    return believed(plain_heights(file, geo_header(file), values[..., 0]))[None]


def _colors_part(file: Path, rows: slice, columns: slice, four: Callable[[NDArray[Any]], Colors]) -> Floats:
    pixels = four(tiff_parts(file).part(rows, columns))
    values = np.moveaxis(pixels[..., :3].astype(np.float64), -1, 0)
    values[:, pixels[..., 3] == 0] = np.nan
    return values


def _with_beside(file: Path, header: GeoHeader, found: Found, of_file: OfFile) -> Callable[[slice, slice], Floats]:
    """Parts of a file that may go beyond its border, where the pixels are those of the files beside it."""
    others: list[tuple[Path, GeoHeader, tuple[int, int]]] = []
    for path in found.beside:
        try:
            beside = geo_header(path)
        except TileError:  # said when it is read itself
            continue
        shift = pixel_shift(header, beside)
        if shift is not None:
            others.append((path, beside, shift))

    def pixels(rows: slice, columns: slice) -> Floats:
        out: Floats | None = None
        for path, of, (right, down) in ((file, header, (0, 0)), *others):
            top, bottom = max(rows.start, down), min(rows.stop, down + of.rows)
            left, end = max(columns.start, right), min(columns.stop, right + of.columns)
            if top >= bottom or left >= end:
                continue
            if out is not None:
                at = slice(top - rows.start, bottom - rows.start), slice(left - columns.start, end - columns.start)
                if not np.isnan(out[0][at]).any():
                    continue
            try:
                part = of_file(path, slice(top - down, bottom - down), slice(left - right, end - right))
            except TileError:
                if path == file:
                    raise
                continue
            if out is None:
                out = np.full((len(part), rows.stop - rows.start, columns.stop - columns.start), np.nan)
            at = slice(top - rows.start, bottom - rows.start), slice(left - columns.start, end - columns.start)
            inside = out[(slice(None), *at)]
            np.copyto(inside, part, where=np.isnan(inside))
        return np.full((1, 1, 1), np.nan) if out is None else out

    return pixels
