"""Makes the pictures of README.md from real runs: `python docs/make_images.py [picture ...]`."""

import io
import sys
from pathlib import Path

from PIL import Image
from rich.console import Console

import planetfall as pf

FOLDER = Path(__file__).parent / "images"
PICTURES = {
    **{view: view for view in ("space", "orbit", "coast", "valley", "near", "glint", "beach")},
    "clouds": "sea",
    "above": "high",
}
"""Pictures, and the views that they are of."""
SIZE, QUALITY = (960, 540), "medium"
LARGEST_BYTES = 150_000


def main(names: list[str]) -> None:
    console = Console()
    FOLDER.mkdir(exist_ok=True)
    with pf.Renderer(pf.load_scene("earth"), SIZE, QUALITY) as renderer:
        for name in names or PICTURES:
            file = FOLDER / f"{name}.jpg"
            file.write_bytes(as_jpeg(renderer.snapshot(pf.view(PICTURES[name])).image))
            console.print(f"wrote {file} ({file.stat().st_size / 1000:.0f} kB)")


def as_jpeg(picture: Image.Image) -> bytes:
    """The best quality that keeps the file small."""
    for quality in range(92, 30, -4):
        buffer = io.BytesIO()
        picture.save(buffer, "JPEG", quality=quality, optimize=True, progressive=True)
        if buffer.tell() <= LARGEST_BYTES:
            break
    return buffer.getvalue()


if __name__ == "__main__":
    main(sys.argv[1:])
