"""Makes the pictures of README.md and first-steps.md from real runs: `python docs/make_images.py [picture ...]`."""

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
SEVERAL = ("moonrise", "earthrise")
"""Pictures of the scene earth_moon, named as their views."""
SIZE, QUALITY = (960, 540), "medium"
LARGEST_BYTES = 150_000
DESCENT = "descent"
"""The animated one: a recording, which goes on where it was interrupted."""


def main(names: list[str]) -> None:
    console = Console()
    FOLDER.mkdir(exist_ok=True)
    if not names or DESCENT in names:
        scene, parts = pf.load_scene("earth"), Path(__file__).parents[1] / "build" / DESCENT
        made = pf.record(scene, DESCENT, parts, count=96, size=(320, 180), fps=12.0, video=False, gif=True)
        file = FOLDER / f"{DESCENT}.gif"
        file.write_bytes(made.gif.read_bytes())
        console.print(f"wrote {file} ({file.stat().st_size / 1000:.0f} kB)")
    pictures = [name for name in names or (*PICTURES, *SEVERAL) if name != DESCENT]
    for scene_name, own in (("earth", PICTURES), ("earth_moon", {name: name for name in SEVERAL})):
        wanted = [name for name in pictures if name in own]
        if not wanted:
            continue
        scene = pf.load_scene(scene_name)
        with pf.Renderer(scene, SIZE, QUALITY) as renderer:
            for name in wanted:
                file = FOLDER / f"{name}.jpg"
                file.write_bytes(as_jpeg(renderer.snapshot(pf.view(own[name], scene.planet)).image))
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
