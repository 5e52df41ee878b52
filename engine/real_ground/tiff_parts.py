"""Parts of a GeoTIFF's first picture: only the strips or tiles that a part lies in are read and decoded, and those that
were asked for last are kept, so that a large file never is in memory whole. Uncompressed files are mapped."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .found import MAPS, TileError
from .geo_tags import file_stamp, tifffile_or_error
from .least_used import LeastUsed

__all__ = ["TiffParts", "tiff_parts"]

Stamp = tuple[str, int, int]
_FILES = 32
_SEGMENT_BYTES = 96 << 20


@dataclass(frozen=True, eq=False)
class TiffParts:
    """A picture (rows, columns, samples of a pixel) of an open file. photometric: TIFF's number for what its samples
    are. mapped: all of it, where it isn't compressed, with samples first where they lie apart."""

    stamp: Stamp
    shape: tuple[int, int, int]
    photometric: int
    apart: bool
    """Whether each sample of pixels has a picture of its own."""
    page: Any
    mapped: NDArray[Any] | None

    def part(self, rows: slice, columns: slice) -> NDArray[Any]:
        """Pixels (rows, columns, samples) of a part within the picture. TileError says what is wrong."""
        if self.mapped is not None:
            found = self.mapped[:, rows, columns] if self.apart else self.mapped[rows, columns]
            return np.moveaxis(found, 0, -1) if self.apart else found
        out = np.zeros((rows.stop - rows.start, columns.stop - columns.start, self.shape[2]), self.page.dtype)
        page = self.page
        high, wide = (
            (page.tilelength, page.tilewidth)
            if page.is_tiled
            else (min(page.rowsperstrip, self.shape[0]), self.shape[1])
        )
        across, down = -(-self.shape[1] // wide), -(-self.shape[0] // high)
        for plane in range(self.shape[2] if self.apart else 1):
            for j in range(rows.start // high, -(-rows.stop // high)):
                for i in range(columns.start // wide, -(-columns.stop // wide)):
                    values = _segments.get((self.stamp, (plane * down + j) * across + i))
                    top, left = max(rows.start, j * high), max(columns.start, i * wide)
                    bottom = min(rows.stop, j * high + values.shape[0])
                    right = min(columns.stop, i * wide + values.shape[1])
                    at = (
                        slice(top - rows.start, bottom - rows.start),
                        slice(left - columns.start, right - columns.start),
                    )
                    inside = values[top - j * high : bottom - j * high, left - i * wide : right - i * wide]
                    if self.apart:
                        out[(*at, plane)] = inside[..., 0]
                    else:
                        out[at] = inside
        return out

    def segment(self, number: int) -> NDArray[Any]:
        """One strip or tile (rows, columns, samples), decoded."""
        page, file = self.page, Path(self.stamp[0])
        offset, size = int(page.dataoffsets[number]), int(page.databytecounts[number])
        words = {}
        if page.compression in (6, 7, 34892, 33007):  # JPEG
            words = {"jpegtables": page.jpegtables, "jpegheader": page.jpegheader}
        try:
            data = None
            if size:
                with file.open("rb") as held:
                    held.seek(offset)
                    data = held.read(size)
                if len(data) < size:
                    raise ValueError(f"its pixels end after {offset + len(data)} bytes")
            values, _, shape = page.decode(data, number, **words)
        except Exception as error:  # decoders raise whatever theirs do
            raise _broken(file, error) from error
        return np.full(shape[1:], page.nodata, page.dtype) if values is None else values[0]


def tiff_parts(file: Path) -> TiffParts:
    """The first picture of a file. TileError says what is wrong."""
    return _files.get(file_stamp(file))


def _open(stamp: Stamp) -> TiffParts:
    tifffile, file = tifffile_or_error(), Path(stamp[0])
    try:
        with tifffile.TiffFile(file) as tiff:
            page = tiff.pages[0]
            apart = int(page.planarconfig) == 2 and page.samplesperpixel > 1
            shape = page.imagelength, page.imagewidth, page.samplesperpixel
            if page.imagedepth != 1:
                raise ValueError(f"it is {page.imagedepth} pictures deep")
            _ = page.jpegtables, page.dataoffsets, page.databytecounts, page.decode, page.nodata  # of the open file
            plain = bool(page.is_memmappable)
        mapped = tifffile.memmap(file, page=0, mode="r") if plain else None
    except Exception as error:
        raise _broken(file, error) from error
    if mapped is not None:
        mapped = mapped.reshape((shape[2], *shape[:2]) if apart else shape)
    return TiffParts(stamp, shape, int(page.photometric), apart, page, mapped)


def _broken(file: Path, error: Exception) -> TileError:
    if "imagecodecs" in str(error):
        return TileError(f"{file} is compressed in a way that needs imagecodecs: {MAPS}")
    return TileError(f"{file} can't be read: {error}; is it whole? Fetch it again, or remove it")


def _segment(key: tuple[Stamp, int]) -> NDArray[Any]:
    return _files.get(key[0]).segment(key[1])


_files: LeastUsed[Stamp, TiffParts] = LeastUsed(_FILES, _open)
_segments: LeastUsed[tuple[Stamp, int], NDArray[Any]] = LeastUsed(
    _SEGMENT_BYTES, _segment, lambda values: values.nbytes
)
