"""Where a tile's samples lie on the world, and what is said of tiles that can't be used."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from ..settings import SettingError
from .lattice import Lattice

__all__ = ["MAPS", "Found", "MissingLibrary", "TileError", "middle_piece", "pieces"]

MAPS = "pip install 'planetfall[maps]'"
_PIECE = 960
"""Samples a side of the squares that warped tiles are read in. Coarser samples are of 2, 3, 4, 5 .. of them."""


class TileError(SettingError):
    """A tile that can't be used: what, where, expected, found, and what to do."""


class MissingLibrary(TileError):
    """The same, until a library is installed."""


@dataclass(frozen=True)
class Found:
    """A tile: its lattice, its first sample there (column, row), and how many columns and rows it has.

    warped: the file has samples of its own, from which those of the lattice are interpolated; then any window of the
    lattice may be read. beside: files around it, whose samples are asked for next to its border.
    """

    lattice: Lattice
    column: int
    row: int
    columns: int
    rows: int
    warped: bool = False
    beside: tuple[Path, ...] = ()

    def window(self, rows: slice, columns: slice) -> Found:
        """Some of its rows and columns."""
        return replace(
            self,
            column=self.column + columns.start,
            row=self.row + rows.start,
            columns=columns.stop - columns.start,
            rows=rows.stop - rows.start,
        )


def pieces(found: Found) -> Iterator[Found]:
    """The tile in parts that are read one by one, so that large ones need little memory: squares where it is warped,
    else all of it."""
    if not found.warped:
        yield found
        return
    for rows in _cut(found.row, found.rows):
        for columns in _cut(found.column, found.columns):
            yield found.window(rows, columns)


def middle_piece(found: Found) -> Found:
    """That of `pieces` in the middle."""
    every = list(pieces(found))
    middle = found.column + found.columns // 2, found.row + found.rows // 2
    return next(
        p for p in every if 0 <= middle[0] - p.column < p.columns and 0 <= middle[1] - p.row < p.rows
    )  # fmt: skip


def _cut(start: int, length: int) -> Iterator[slice]:
    """Slices of a run of samples that end at multiples of _PIECE."""
    at = start
    while at < start + length:
        end = min((at // _PIECE + 1) * _PIECE, start + length)
        yield slice(at - start, end - start)
        at = end
