"""How alike two pictures are (NVIDIA's FLIP), what still counts as the same, and pages that show a difference.

The limits were measured: docs/testing.md has the table, `python tests/kits/golden_tool.py --measure` makes it anew.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from planetfall.benchmarks.measure.flip import flip
from planetfall.systems.capture import contact_sheet
from planetfall.systems.capture.png import KEY


@dataclasses.dataclass(frozen=True)
class Likeness:
    """FLIP between two pictures: 0 the same, 1 as different as black and white.

    mean: over the picture. p999: the value that one pixel in a thousand exceeds (58 of 320 x 180). worst: the largest.
    error: (H, W) of every pixel.
    """

    mean: float
    p999: float
    worst: float
    error: NDArray[np.float32] = dataclasses.field(repr=False)

    def within(self, limit: Limit) -> bool:
        return self.mean <= limit.mean and self.p999 <= limit.p999

    def __str__(self) -> str:
        return f"FLIP mean {self.mean:.5f}, 99.9th percentile {self.p999:.4f}, worst pixel {self.worst:.3f}"


@dataclasses.dataclass(frozen=True)
class Limit:
    """What counts as the same picture. The worst pixel has no say: where a silhouette passes through a pixel's centre,
    rounding decides whether it is ground or sky."""

    mean: float
    p999: float

    def __str__(self) -> str:
        return f"mean {self.mean:g}, 99.9th percentile {self.p999:g}"


SAME = Limit(mean=0.0005, p999=0.016)
"""On Mesa's software renderer: halfway, as a factor, between what other CPUs change and the smallest real changes."""
OTHER_DRIVER = Limit(mean=0.02, p999=0.45)
"""On any other driver, whose edges of triangles may lie elsewhere: what a camera turned by 0.1 pixel changes."""


def likeness(expected: NDArray[np.uint8], actual: NDArray[np.uint8]) -> Likeness:
    """FLIP between two u8 pictures (H, W, 3) of one size."""
    error = flip(expected, actual)
    return Likeness(float(error.mean()), float(np.percentile(error, 99.9)), float(error.max()), error)


def limit_for(renderer: str) -> Limit:
    """The limit for pictures of this GL renderer; the golden ones are llvmpipe's."""
    return SAME if "llvmpipe" in renderer.lower() else OTHER_DRIVER


def read_picture(path: Path) -> NDArray[np.uint8]:
    with Image.open(path) as image:
        return np.asarray(image.convert("RGB"), np.uint8)


def write_picture(path: Path, pixels: NDArray[np.uint8], settings: Mapping[str, Any]) -> None:
    """A PNG as small as Pillow makes it, with the settings inside as Planetfall's own pictures carry them."""
    info = PngInfo()
    info.add_text("Software", "Planetfall")
    info.add_itxt(KEY, json.dumps(settings, ensure_ascii=False, sort_keys=True))
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(pixels).save(path, format="PNG", pnginfo=info, optimize=True)


def heat(error: NDArray[np.float32], full: float = 0.25) -> NDArray[np.uint8]:
    """An error map in colours: black 0, through red and yellow, to white at `full`. (H, W, 3) u8."""
    x = np.clip(error / full, 0.0, 1.0)[..., None] * 3.0 - np.arange(3.0)
    return np.round(np.clip(x, 0.0, 1.0) * 255.0).astype(np.uint8)


def difference_page(
    name: str, expected: NDArray[np.uint8], actual: NDArray[np.uint8], error: NDArray[np.float32]
) -> NDArray[np.uint8]:
    """golden | actual | difference side by side, at least 320 pixels wide each."""
    pictures = (("golden", expected), ("actual", actual), ("FLIP, white at 0.25", heat(error)))
    times = max(1, -(-320 // expected.shape[1]))
    scaled = [(label, p.repeat(times, axis=0).repeat(times, axis=1)) for label, p in pictures]
    return contact_sheet(scaled, columns=3, thumb_width=scaled[0][1].shape[1], title=name)
