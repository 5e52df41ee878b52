"""`planetfall render`, `gallery` and `record`: pictures and arrays without a display."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from cyclopts import Parameter
from rich.console import Console

from ._version import __version__
from .cli_options import CameraOptions, Planet, Quality, Set, Size, SunOptions, parse_overrides, parse_size
from .cli_progress import counted, settling
from .errors import CameraError, OutputError
from .recording import record
from .shot import camera_settings
from .systems.capture import contact_sheet, require_writable, write_arrays, write_png
from .systems.capture.video import ffmpeg

if TYPE_CHECKING:
    from .renderer import Renderer
    from .scene import Scene

__all__ = ["gallery_command", "record_command", "render_command"]

DEFAULT_VIEW = "orbit"
ARRAYS = ("color", "radiance", "distance", "position", "normal", "surface")

console = Console()

Output = Annotated[Path, Parameter(name=["--output", "-o"])]
Force = Annotated[bool, Parameter(negative="", help="Make again what is there already.")]


def render_command(
    planet: Planet = "earth",
    *,
    view: str | None = None,
    camera: CameraOptions = CameraOptions(),  # noqa: B008 - frozen
    sun: SunOptions = SunOptions(),  # noqa: B008 - frozen
    size: Size = "1280x720",
    quality: Quality = "high",
    overrides: Set = (),
    time_s: float | None = None,
    output: Output = Path("planetfall.png"),
) -> None:
    """Render one picture, or all its arrays.

    Parameters
    ----------
    view
        A named view (see `planetfall views`): camera, sun and time. orbit, if no camera is given either.
    time_s
        Moves water and weather, and an epoch sun. Left out: the view's time, else 0.
    output
        picture.png, with the settings inside, or arrays.npz with every output, the camera and the exposure.
    """
    if output.suffix.lower() not in (".png", ".npz"):
        raise OutputError(f"--output: expected a name ending in .png or .npz, found {str(output)!r}")
    require_writable(output)
    pixels, knobs = parse_size(size), parse_overrides(overrides)
    if view is not None and camera.given():
        raise CameraError("--view and camera options exclude each other: a view brings its own camera")
    from . import load_scene

    scene = load_scene(planet)
    shot = camera.camera() if camera.given() else find_view(view or DEFAULT_VIEW, scene)
    light = sun.sun(scene, shot)
    settings = {
        "planetfall": __version__, "planet": planet, "view": None if camera.given() else view or DEFAULT_VIEW,
        "size": list(pixels), "quality": quality, "overrides": knobs, "time_s": time_s, "sun": light and repr(light),
    }  # fmt: skip
    from .renderer import Renderer  # late: everything that can be said without a GPU has been said

    with Renderer(scene, pixels, quality, knobs) as renderer:
        with settling(console) as progress:
            renderer.settle(shot, time_s, sun=light, progress=progress)
        wanted = ARRAYS if output.suffix.lower() == ".npz" else ("color",)
        out = renderer.render(shot, time_s, sun=light, outputs=wanted)
        state = camera_settings(renderer.camera_state(shot))
        settings["exposure"] = exposure_of(renderer)
    if output.suffix.lower() == ".npz":
        write_arrays(output, out, camera=numbers_of(state), exposure=settings["exposure"], settings=settings)
    else:
        write_png(output, out["color"], {**settings, "camera": state})
    console.print(f"wrote [bold]{output}[/]", highlight=False, soft_wrap=True)


def gallery_command(
    planet: Planet = "earth",
    *,
    views: Annotated[tuple[str, ...], Parameter(name="--view", negative="", consume_multiple=False)] = (),
    size: Size = "640x360",
    quality: Quality = "high",
    overrides: Set = (),
    force: Force = False,
    output: Output = Path("gallery"),
) -> None:
    """Render the named views of a planet and a contact sheet of them; goes on where it was interrupted.

    Parameters
    ----------
    views
        Only this view. Repeatable; all that make sense for the planet, if left out.
    output
        The folder; made when missing.
    """
    require_writable(output, make_folder=True)
    pixels, knobs = parse_size(size), parse_overrides(overrides)
    from . import load_scene

    scene = load_scene(planet)
    names = list(views) or views_for(scene)
    shots = {name: find_view(name, scene) for name in names}
    settings = {
        "planetfall": __version__,
        "planet": planet,
        "size": list(pixels),
        "quality": quality,
        "overrides": knobs,
    }
    files = {name: output / f"{scene.name}_{name}.png" for name in names}
    todo = [name for name in names if force or not files[name].exists()]
    if todo:
        from .renderer import Renderer

        with Renderer(scene, pixels, quality, knobs) as renderer, counted(console, "views", len(todo)) as progress:
            for done, name in enumerate(todo, 1):
                renderer.settle(shots[name])
                color = renderer.render(shots[name])["color"]
                state = camera_settings(renderer.camera_state(shots[name]))
                write_png(files[name], color, {**settings, "view": name, "camera": state})
                progress(done, len(todo))
    sheet = output / f"{scene.name}.png"
    write_png(sheet, contact_sheet([(name, files[name]) for name in names], title=scene.name), settings)
    console.print(
        f"wrote {len(todo)} of {len(names)} views and [bold]{sheet}[/]"
        + ("" if len(todo) == len(names) else " (the others were there; --force makes them again)"),
        highlight=False,
        soft_wrap=True,
    )


def record_command(
    planet: Planet = "earth",
    *,
    path: str = "descent",
    count: int = 240,
    size: Size = "640x360",
    quality: Quality = "medium",
    overrides: Set = (),
    fps: float = 24.0,
    video: bool = True,
    force: Force = False,
    output: Output = Path("flight"),
) -> None:
    """Render a scripted flight as numbered PNGs, a contact sheet and a video; goes on where it was interrupted.

    Parameters
    ----------
    path
        The flight: descent or low.
    count
        Number of frames, spread evenly over the flight.
    fps
        Frames a second of the video.
    video
        Make the video too (needs the extra 'video').
    output
        The folder; made when missing.
    """
    require_writable(output, make_folder=True)
    pixels, knobs = parse_size(size), parse_overrides(overrides)
    if video:
        ffmpeg()
    from . import load_scene

    scene = load_scene(planet)
    with counted(console, "frames", count) as progress:
        made = record(
            scene, path, output, count=count, size=pixels, quality=quality, overrides=knobs, fps=fps, video=video,
            force=force, progress=progress,
        )  # fmt: skip
    console.print(f"wrote {len(made.frames)} frames, {made.frames[0]} ... {made.frames[-1].name}", highlight=False)
    for file in (made.sheet, made.video):
        if file is not None:
            console.print(f"wrote [bold]{file}[/]", highlight=False, soft_wrap=True)


def find_view(name: str, scene: Scene) -> Any:
    """A named view of a scene's planet; UnknownNameError with the nearest name."""
    from . import view

    return view(name, scene.planet)


def views_for(scene: Scene) -> list[str]:
    """The named views that make sense for a scene's planet."""
    from . import views

    return list(views(scene.planet))


def numbers_of(state: dict[str, Any]) -> dict[str, Any]:
    """Those camera settings that are numbers."""
    return {name: value for name, value in state.items() if np.issubdtype(np.asarray(value).dtype, np.number)}


def exposure_of(renderer: Renderer) -> float | None:
    """The exposure that the last frame was shown with, as the renderer tells it; None when it does not."""
    value = getattr(renderer, "exposure", None)
    value = value() if callable(value) else value
    return float(value) if isinstance(value, int | float | np.number) and math.isfinite(value) else None
