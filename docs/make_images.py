"""Makes the pictures of README.md, first-steps.md, rivers.md and sources.md from real runs: `python
docs/make_images.py [picture ...]`."""

import io
import math
import sys
import tempfile
from pathlib import Path

import matplotlib as mpl
import numpy as np
from PIL import Image
from rich.console import Console

import planetfall as pf
from planetfall.benchmarks.suites.papers import PICTURES as VIEWS
from planetfall.capture.river_map import river_map
from planetfall.games.afloat import main as afloat
from planetfall.query.drainage import climate_params, network_below
from planetfall.systems.capture import contact_sheet

FOLDER = Path(__file__).parent / "images"
PICTURES = {
    **{view: view for view in ("space", "orbit", "coast", "valley", "ground", "dusk", "glint", "beach", "waterfall")},
    "clouds": "sea",
    "above": "high",
}
"""Pictures, and the views that they are of."""
SEVERAL = ("moonrise", "earthrise")
"""Pictures of the scene earth_moon, named as their views."""
WOODS = {
    **{
        view: view
        for view in (
            "forest",
            "meadow",
            "woodland",
            "canopy",
            "treeline",
            "grove",
            "savanna",
            "desert",
            "palms",
            "lakeside",
            "mangroves",
        )
    },
    "hills": "near",
    "treeline_winter": "treeline",
    "winter": "ground",
}
"""Pictures of trees, and their views."""
SEASONS = {"woodland": 0.79, "treeline_winter": 0.0, "winter": 0.0}
"""Terrain.season of some."""
SIZE, QUALITY = (960, 540), "medium"
LARGEST_BYTES = 150_000
DESCENT = "descent"
"""The animated one: a recording, which goes on where it was interrupted."""
THUMB = (320, 180)


def main(names: list[str]) -> None:
    console = Console()
    FOLDER.mkdir(exist_ok=True)
    if not names or DESCENT in names:
        scene, parts = pf.load_scene("earth"), Path(__file__).parents[1] / "build" / DESCENT
        made = pf.record(scene, DESCENT, parts, count=96, size=(320, 180), fps=12.0, video=False, gif=True)
        file = FOLDER / f"{DESCENT}.gif"
        file.write_bytes(made.gif.read_bytes())
        console.print(f"wrote {file} ({file.stat().st_size / 1000:.0f} kB)")
    for name, drawn in SHEETS.items():
        if not names or name in names:
            file = FOLDER / f"{name}.jpg"
            file.write_bytes(as_jpeg(drawn(), 2 * LARGEST_BYTES))
            console.print(f"wrote {file} ({file.stat().st_size / 1000:.0f} kB)")
    pictures = [name for name in names or (*PICTURES, *SEVERAL, *WOODS) if name not in (DESCENT, *SHEETS)]
    scenes = {"earth": PICTURES | WOODS, "earth_moon": {name: name for name in SEVERAL}}
    for scene_name, own in scenes.items():
        wanted = [name for name in pictures if name in own]
        if not wanted:
            continue
        scene = pf.load_scene(scene_name)
        with pf.Renderer(scene, SIZE, QUALITY) as renderer:
            for name in wanted:
                file = FOLDER / f"{name}.jpg"
                if name in WOODS:
                    scene.planet[pf.Terrain].season = SEASONS.get(name)
                view = pf.view(own[name], scene.planet)
                # Views are exposed for summer; snow is brighter.
                shown = view.exposed(view.ev100 + 0.6) if SEASONS.get(name) == 0.0 else view
                file.write_bytes(as_jpeg(renderer.snapshot(shown).image))
                console.print(f"wrote {file} ({file.stat().st_size / 1000:.0f} kB)")


def paper_sheet() -> Image.Image:
    """Views in pairs: quality paper on the left, ours at quality medium on the right."""
    scene, cells = pf.load_scene("earth"), []
    for quality, who in (("paper", "as printed"), (QUALITY, "ours")):
        with pf.Renderer(scene, THUMB, quality) as renderer:
            for name in VIEWS:
                cells.append((f"{name}, {who}", renderer.snapshot(pf.view(name, scene.planet)).array))
    pairs = [cell for pair in zip(cells[: len(VIEWS)], cells[len(VIEWS) :], strict=True) for cell in pair]
    return Image.fromarray(contact_sheet(pairs, columns=4, thumb_width=THUMB[0]))


def rivers() -> Image.Image:
    """The map of Earth's rivers that `planetfall rivers` draws."""
    scene = pf.load_scene("earth")
    made = river_map(network_below(scene.planet), (1200, 600), climate_params(scene.planet[pf.Terrain]))
    return Image.fromarray(made)


def gullies() -> Image.Image:
    """The mountains of a view without and with them."""
    scene, sheet = pf.load_scene("earth"), Image.new("RGB", (960, 360))
    for column, erosion in enumerate((0.0, 1.0)):
        scene.planet[pf.Terrain].erosion = erosion
        with pf.Renderer(scene, (960, 540), "high") as renderer:
            picture = renderer.snapshot(pf.view("valley", scene.planet)).image
        sheet.paste(picture.crop((440, 40, 920, 400)), (480 * column, 0))
    return sheet


def tile_gullies() -> Image.Image:
    """The fault at Jacksboro, which matplotlib ships in 3 arc seconds, three times as high, without and with gullies
    below its samples."""
    file = Path(mpl.get_data_path()) / "sample_data" / "jacksboro_fault_dem.npz"
    metres = np.load(file)["elevation"].astype(float)
    tile = np.full((1201, 1201), -32768, ">i2")  # no samples, but for a corner
    tile[: metres.shape[0], : metres.shape[1]] = np.rint(3.0 * (metres - metres.min()))
    scene, sheet = pf.load_scene("earth"), Image.new("RGB", (960, 360))
    terrain = scene.planet[pf.Terrain]
    terrain.rivers = 0.0
    for kind in (pf.Clouds, pf.Cover):
        scene.planet.remove(kind)
    place = {"latitude_deg": 36.847, "longitude_deg": -84.836}
    scene.sun = pf.Sun(elevation_deg=30.0, azimuth_deg=60.0, **place)
    camera = pf.Camera.at(**place, altitude_m=3000.0, heading_deg=300.0, pitch_deg=-35.0, above="ground")
    with tempfile.TemporaryDirectory() as folder:
        tile.tofile(Path(folder) / "N36W085.hgt")
        terrain.height_map = folder
        for column, erosion in enumerate((0.0, 1.0)):
            terrain.erosion = erosion
            with pf.Renderer(scene, (960, 540), "high") as renderer:
                picture = renderer.snapshot(camera).image
            sheet.paste(picture.crop((300, 150, 780, 510)), (480 * column, 0))
    return sheet


def raft() -> Image.Image:
    """The raft of games/afloat after twenty seconds."""
    with tempfile.TemporaryDirectory() as folder:
        shot = ["--raft", "--frames", "1", "--skip-s", "20", "--size", *map(str, SIZE), "--quality", QUALITY]
        afloat.main([*shot, "--output", folder])
        return Image.open(Path(folder) / "raft_0000.png").copy()


def lenses() -> Image.Image:
    """A view through a wide lens with barrel distortion, a fisheye of half a turn, and all around."""
    turn = 2.0 * math.pi
    barrel = pf.Intrinsics(480, 270, 240.0, 240.0, 239.5, 134.5, (-0.28, 0.09, 0.0, 0.0), "brown")
    fisheye = pf.Intrinsics(480, 270, 960 / turn, 960 / turn, 239.5, 134.5, (), "fisheye")
    around = pf.Intrinsics(960, 300, 960 / turn, 960 / turn, 479.5, 149.5, (), "equirectangular")
    scene, sheet = pf.load_scene("earth"), Image.new("RGB", (960, 570))
    view = pf.view("coast", scene.planet)
    with pf.Renderer(scene, SIZE, QUALITY) as renderer:
        for lens, place in ((barrel, (0, 0)), (fisheye, (480, 0)), (around, (0, 270))):
            sheet.paste(renderer.snapshot(view.with_intrinsics(lens)).image, place)
    return sheet


SHEETS = {
    "paper": paper_sheet,
    "rivers": rivers,
    "gullies": gullies,
    "tile_gullies": tile_gullies,
    "raft": raft,
    "lenses": lenses,
}
"""Drawn by functions of their own: the sources' methods beside ours, a map, a game, and lenses."""


def as_jpeg(picture: Image.Image, largest_bytes: int = LARGEST_BYTES) -> bytes:
    """The best quality that keeps the file small."""
    for quality in range(92, 30, -4):
        buffer = io.BytesIO()
        picture.save(buffer, "JPEG", quality=quality, optimize=True, progressive=True)
        if buffer.tell() <= largest_bytes:
            break
    return buffer.getvalue()


if __name__ == "__main__":
    main(sys.argv[1:])
