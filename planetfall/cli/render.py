"""`planetfall render` and `record`: pictures and arrays without a display."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from cyclopts import Parameter

from ..camera.flights import path as scripted
from ..camera.intrinsics import Intrinsics
from ..capture.captures import check_arrays, check_suffix, outputs_for, save_capture
from ..capture.dataset_plan import parse_range
from ..capture.photos import PhotoPlan, photo_tiles
from ..capture.recording import record
from ..capture.shot import load_shot, shot_settings
from ..errors import CameraError, SettingError, SizeError
from ..systems.capture import require_writable
from ..systems.capture.video import ffmpeg
from ..systems.flight import PATHS_FILE
from .options import CameraOptions, Planet, Quality, Set, Size, SunOptions, parse_overrides, parse_size
from .progress import console, counted, settling, written

if TYPE_CHECKING:
    from ..camera.camera import Camera
    from ..camera.views import View
    from ..render.renderer import Renderer
    from ..scene.scene import Scene

__all__ = ["record_command", "render_command"]

DEFAULT_VIEW = "orbit"

Output = Annotated[Path, Parameter(name=["--output", "-o"])]
Force = Annotated[bool, Parameter(negative="", help="Make again what is there already.")]


def render_command(
    planet: Annotated[str | None, Parameter(help="A planet's name, or a scene's TOML file; earth if left out.")] = None,
    *,
    view: str | None = None,
    camera: CameraOptions = CameraOptions(),  # noqa: B008 - frozen
    sun: SunOptions = SunOptions(),  # noqa: B008 - frozen
    size: Size | None = None,
    quality: Quality | None = None,
    overrides: Set = (),
    time_s: float | None = None,
    like: Path | None = None,
    ev100: float | None = None,
    intrinsics: Path | None = None,
    supersample: int | None = None,
    tile_px: int = 2048,
    outputs: str | None = None,
    output: Output = Path("planetfall.png"),
) -> None:
    """Render one picture of any size, or all its arrays.

    Parameters
    ----------
    view
        A named view (see `planetfall views`): camera, sun and time. orbit, if no camera is given either.
    time_s
        Moves water and weather, and an epoch sun. Left out: the view's time, else 0.
    like
        A picture or arrays of ours: takes everything from the settings inside it; other options change single things.
    ev100
        A fixed exposure; left out, it adapts.
    intrinsics
        A calibrated camera's YAML file, of OpenCV or ROS: its lens, and with it the size.
    supersample
        Samples a side for every pixel, averaged: 2 takes four times as long.
    tile_px
        Larger pictures are rendered in tiles of at most so many samples a side.
    outputs
        Which arrays a .npz or .exr holds, such as color,depth,normal,material: any of docs/labels.md but flow. Left
        out: color, radiance, distance, position, normal, surface.
    output
        picture.png, arrays.npz or arrays.exr. All of them have the settings inside.
    """
    check_suffix(output, "--output")
    require_writable(output)
    wanted = outputs_for(output, [name.strip() for name in (outputs or "").split(",") if name.strip()])
    if view is not None and camera.given():
        raise CameraError("--view and camera options exclude each other: a view brings its own camera")
    if like is not None and planet is not None:
        raise SettingError("--like brings its own planet: leave the planet's name out")
    from .. import load_scene

    like_shot = load_shot(like) if like is not None else None
    pixels = parse_size(size) if size is not None else like_shot.size if like_shot else (1280, 720)
    knobs = {**(like_shot.overrides if like_shot else {}), **parse_overrides(overrides)}
    chosen = quality or (like_shot.quality if like_shot else "high")
    scene = like_shot.scene if like_shot else load_scene(planet or "earth")
    if camera.given():
        shot = camera.camera()
    elif like_shot and view is None:
        shot = like_shot.camera
    else:
        shot = find_view(view or DEFAULT_VIEW, scene)
    if intrinsics is not None:
        shot = shot.with_intrinsics(Intrinsics.load(intrinsics))
    lens = shot.intrinsics
    if lens is not None:
        if size is not None and pixels != lens.size:
            raise SizeError(f"--size: the intrinsics are for {lens.width} x {lens.height} pixels, found {size}")
        pixels = lens.size
    light = sun.sun(scene, shot)
    if like_shot and time_s is None:
        time_s = like_shot.time_s
    exposure = ev100 if ev100 is not None or not like_shot else like_shot.ev100
    samples = supersample if supersample is not None else like_shot.supersample if like_shot else 1
    plan = PhotoPlan(pixels, samples, tile_px, exposure)
    check_arrays(output, pixels)
    from ..render.renderer import Renderer  # late: everything that can be said without a GPU has been said

    placed = shot.in_scene(scene)
    moment = (placed.time_s or 0.0) if time_s is None else time_s
    light = placed.sun if light is None else light
    whole = len(plan.tiles()) == 1 and plan.supersample == 1
    out: dict[str, Any] = {}
    with Renderer(scene, pixels if whole else (64, 64), chosen, knobs) as renderer:
        if whole:
            seen = shot if plan.ev100 is None else shot.exposed(plan.ev100)
            with settling() as settled:
                renderer.settle(seen, moment, sun=light, progress=settled)
            out = renderer.render(seen, moment, sun=light, outputs=wanted)
        else:
            with counted("tiles", len(plan.tiles())) as progress:
                for done, count, arrays in photo_tiles(renderer, shot, plan, moment, light, wanted):
                    progress(done, count)
                    out = arrays
        materials = {"materials": renderer.materials} if "material" in wanted else {}
        state = shot.resolve(scene, pixels[0] / pixels[1]).moved(renderer.camera_state(shot).position_m)
        settings = shot_settings(
            scene, state, moment, pixels, quality=chosen, overrides=knobs, sun=light, supersample=plan.supersample,
            ev100=exposure_of(renderer), over=companion_below(scene, shot), intrinsics=lens,
        )  # fmt: skip
    settings |= {
        **materials,
        "planet": planet or scene.name,
        "view": None if camera.given() or like_shot else view or DEFAULT_VIEW,
    }
    save_capture(output, out, settings)
    written(output)


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
    gif: bool = False,
    paths: Path | None = None,
    frames: str = ":",
    scheduler: str | None = None,
    force: Force = False,
    output: Output = Path("flight"),
) -> None:
    """Render a scripted flight as numbered PNGs, a contact sheet and a video; goes on where it was interrupted.

    Parameters
    ----------
    path
        The flight: descent, low, or one of your own file's.
    count
        Number of frames, spread evenly over the flight.
    fps
        Frames a second of the video.
    video
        Make the video too (needs the extra 'video').
    gif
        Make an animated GIF too.
    paths
        A TOML file with flights of your own, written like assets/presets/paths.toml.
    frames
        A:B, those from A up to, not with, B alone; whoever finds all frames there makes the video.
    scheduler
        Address of a Dask scheduler, such as tcp://10.0.0.5:8786, whose workers make the frames (extra 'farm').
    output
        The folder; made when missing.
    """
    wanted = parse_range(frames, count)
    require_writable(output, make_folder=True)
    pixels, knobs = parse_size(size), parse_overrides(overrides)
    if video:
        ffmpeg()
    from .. import load_scene

    scene = load_scene(planet)
    flight = scripted(path, scene, PATHS_FILE if paths is None else paths)
    with counted("frames", len(wanted)) as progress:
        made = record(
            scene, flight, output, count=count, size=pixels, quality=quality, overrides=knobs, fps=fps, video=video,
            gif=gif, force=force, frames=wanted, scheduler=scheduler,
            progress=progress,
        )  # fmt: skip
    console.print(f"{len(made.frames)} frames, {made.frames[0]} ... {made.frames[-1].name}", soft_wrap=True)
    written(made.sheet, made.video, made.gif)


def find_view(name: str, scene: Scene) -> View:
    """A named view of a scene's planet; UnknownNameError with the nearest name."""
    from .. import view

    return view(name, scene.planet)


def companion_below(scene: Scene, camera: Camera) -> str:
    """The companion in whose axes a camera is given; "" for the scene's own planet."""
    handle = camera.planet_in(scene)
    return "" if handle is scene.planet else handle.name


def views_for(scene: Scene) -> list[str]:
    """The named views that make sense for a scene's planet."""
    from ..camera.views import views

    return list(views(scene.planet))


def exposure_of(renderer: Renderer) -> float | None:
    """The exposure that the last frame was shown with, as the renderer tells it; None when it does not."""
    value = getattr(renderer, "exposure", None)
    value = value() if callable(value) else value
    return float(value) if isinstance(value, int | float | np.number) and math.isfinite(value) else None
