"""Makes the pictures of README.md from real runs: `python docs/make_images.py [view ...]`."""

import io
import sys
from pathlib import Path

from PIL import Image
from rich.console import Console

import planetfall as pf

FOLDER = Path(__file__).parent / "images"
VIEWS = ("space", "orbit", "coast", "valley", "near", "glint", "beach")
CLOUDY = {"clouds": "sea"}
"""Pictures of a scene with clouds, and their views."""
SIZE = (960, 540)
LARGEST_BYTES = 150_000


def main(names: list[str]) -> None:
    console = Console()
    FOLDER.mkdir(exist_ok=True)
    wanted = names or [*VIEWS, *CLOUDY]
    for cloudy in (False, True):
        views = {name: CLOUDY.get(name, name) for name in wanted if (name in CLOUDY) == cloudy}
        if not views:
            continue
        scene = pf.load_scene("earth")
        if cloudy:
            scene.planet.add(pf.Clouds())
        with pf.Renderer(scene, SIZE, "high") as renderer:
            for name, view in views.items():
                file = FOLDER / f"{name}.jpg"
                file.write_bytes(as_jpeg(renderer.snapshot(pf.view(view)).image))
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
