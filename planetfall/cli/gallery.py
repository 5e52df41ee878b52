"""`planetfall gallery`: many views of a planet, or the best of all planets."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from .._version import __version__
from ..capture.shot import camera_settings, made_of
from ..errors import SettingError
from ..systems.capture import CaptureError, contact_sheet, read_png_settings, require_writable, write_png
from .options import Planet, Quality, Set, Size, parse_overrides, parse_size
from .progress import console, counted, written
from .render import Force, Output, find_view, views_for

__all__ = ["gallery_command"]

SIZE, QUALITY = "640x360", "high"
BEST_SIZE, BEST_QUALITY = "1280x720", "ultra"


def gallery_command(
    planet: Planet = "earth",
    *,
    views: Annotated[tuple[str, ...], Parameter(name="--view", negative="", consume_multiple=False)] = (),
    best: Annotated[
        bool, Parameter(negative="", help="The sixteen best views of all planets, as JPEGs with a page.")
    ] = False,
    size: Size | None = None,
    quality: Quality | None = None,
    overrides: Set = (),
    force: Force = False,
    output: Output = Path("gallery"),
) -> None:
    """Render the named views of a planet and a contact sheet of them; goes on where it was interrupted.

    Parameters
    ----------
    views
        Only this view. Repeatable; all that make sense for the planet, if left out.
    size
        Width x height in pixels: 640x360, with --best 1280x720.
    quality
        low, medium, high, ultra, reference or paper: high, with --best ultra.
    output
        The folder; made when missing.
    """
    require_writable(output, make_folder=True)
    pixels, knobs = parse_size(size or (BEST_SIZE if best else SIZE)), parse_overrides(overrides)
    if best:
        if views or planet != "earth":
            raise SettingError("--best has planets and views of its own: leave the planet's name and --view out")
        from ..capture.gallery import BEST, best_gallery

        with counted("pictures", len(BEST)) as progress:
            shown = best_gallery(output, size=pixels, quality=quality or BEST_QUALITY, overrides=knobs, force=force,
                                 progress=progress)  # fmt: skip
        console.print(f"wrote {shown.made} of {len(shown.pictures)} pictures", highlight=False)
        written(shown.page)
        return
    quality = quality or QUALITY
    from .. import load_scene

    scene = load_scene(planet)
    names = list(views) or views_for(scene)
    shots = {name: find_view(name, scene) for name in names}
    settings = {
        "planetfall": __version__,
        "planet": planet,
        "size": list(pixels),
        "quality": quality,
        "overrides": knobs,
        "made_of": made_of(scene),
    }
    files = {name: output / f"{scene.name}_{name}.png" for name in names}
    todo = [name for name in names if force or not _is_there(files[name], settings)]
    if todo:
        from ..render.renderer import Renderer

        with Renderer(scene, pixels, quality, knobs) as renderer, counted("views", len(todo)) as progress:
            for done, name in enumerate(todo, 1):
                renderer.settle(shots[name])
                color = renderer.render(shots[name])["color"]
                state = camera_settings(renderer.camera_state(shots[name]))
                write_png(files[name], color, {**settings, "view": name, "camera": state})
                progress(done, len(todo))
    sheet = output / f"{scene.name}.png"
    write_png(sheet, contact_sheet([(name, files[name]) for name in names], title=scene.name), settings)
    console.print(
        f"wrote {len(todo)} of {len(names)} views"
        + ("" if len(todo) == len(names) else " (the others were there, made of the same; --force makes them again)"),
        highlight=False,
        soft_wrap=True,
    )
    written(sheet)


def _is_there(file: Path, settings: dict[str, Any]) -> bool:
    """Whether a picture of the same scene and settings is there, or one that is none of ours and stays."""
    if not file.exists():
        return False
    try:
        return read_png_settings(file).items() >= json.loads(json.dumps(settings)).items()
    except CaptureError:
        return True
