"""Stress suite frame: random scenes and whole presets, cameras, suns, times and sizes; finite pictures and no OpenGL
error."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ... import Atmosphere, Camera, Clouds, Ocean, Planet, Renderer, Sun, Terrain
from ..scenes import preset_scene
from ..session import Session
from .draw import unit
from .runner import Case, Found, Kind
from .scenes import build_camera, build_scene, draw_camera, draw_light, draw_planet
from .terrain import OUTPUTS, check_outputs

_SIZES = [[1, 1], [1, 64], [64, 1], [3, 5], [17, 33], [128, 72], [200, 40]]


def _draw_picture(rng: np.random.Generator) -> Case:
    scene = {**draw_planet(rng), **draw_light(rng)}
    if rng.random() < 0.1:
        del scene["terrain"]
    case = {"scene": scene, "camera": draw_camera(rng), "size": _SIZES[int(rng.integers(len(_SIZES)))]}
    return {**case, "quality": str(rng.choice(["low", "medium", "high"])), "time_s": float(rng.choice([0.0, 1e3, 1e9]))}


def _check_picture(case: Case, session: Session) -> Found:
    """One picture, twice: finite, and the same bits again."""
    found = Found()
    scene = build_scene(case["scene"])
    with session.renderer(scene, tuple(case["size"]), case["quality"]) as renderer:
        camera = build_camera(scene, case["camera"])
        out = renderer.render(camera, time_s=case["time_s"], outputs=OUTPUTS)
        check_outputs(found, out)
        _no_error(found, renderer)
        again = renderer.render(camera, time_s=case["time_s"], outputs=OUTPUTS)
        for name in ("position", "normal", "surface"):
            same = out[name].tobytes() == again[name].tobytes()
            found.expect(same, f"{name}: another picture of the same thing differs")
    scene.release()
    return found


def _draw_flight(rng: np.random.Generator) -> Case:
    scene = {**draw_planet(rng), **draw_light(rng)}
    cameras = [draw_camera(rng) for _ in range(6)]
    for number in range(1, len(cameras)):  # some close to the one before, some teleports
        if rng.random() < 0.6:
            near = np.array(cameras[number - 1]["zenith"]) + rng.normal(size=3) * 10.0 ** rng.uniform(-9.0, -1.0)
            cameras[number]["zenith"] = [float(x) for x in near]
            cameras[number]["clearance_m"] = cameras[number - 1]["clearance_m"] * float(rng.uniform(0.5, 2.0))
    sizes = [_SIZES[int(rng.integers(len(_SIZES)))] for _ in cameras]
    changes = [str(rng.choice(["", "", "sea", "ground", "seed", "radius"])) for _ in cameras]
    return {"scene": scene, "cameras": cameras, "sizes": sizes, "changes": changes, "quality": "low"}


def _check_flight(case: Case, session: Session) -> Found:
    """One renderer through cameras, sizes and changes of the scene; then the same picture as a fresh renderer's."""
    found = Found()
    scene = build_scene(case["scene"])
    with session.renderer(scene, tuple(case["sizes"][0]), case["quality"]) as renderer:
        camera: Camera | None = None
        for drawn, size, change in zip(case["cameras"], case["sizes"], case["changes"], strict=True):
            _change(scene.planet, change)
            renderer.resize(tuple(size))
            camera = build_camera(scene, drawn)
            check_outputs(found, renderer.render(camera, outputs=OUTPUTS))
            _no_error(found, renderer)
        assert camera is not None
        # A held proxy may be another than a new one, which is a function of the position alone: compare after a cut.
        renderer.settle(camera)
        last = renderer.render(camera, outputs=("surface", "position"))
    with session.renderer(scene, tuple(case["sizes"][-1]), case["quality"]) as fresh:
        fresh.settle(camera)
        first = fresh.render(camera, outputs=("surface", "position"))
    differs = int((first["surface"] != last["surface"]).sum())
    found.expect(differs == 0, f"{differs} pixels show another surface than a fresh renderer's")
    scene.release()
    return found


def _change(planet: object, change: str) -> None:
    handle: Any = planet
    if change == "sea":
        if handle.has(Ocean):
            handle.remove(Ocean)
        else:
            handle.add(Ocean())
    elif change == "ground" and handle.has(Terrain):
        handle[Terrain].roughness = 0.3 if handle[Terrain].roughness != 0.3 else 1.0
    elif change == "seed" and handle.has(Terrain):
        handle[Terrain].seed += 1
    elif change == "radius":
        handle[Planet].radius_m *= 1.01


def _draw_boundary(rng: np.random.Generator) -> Case:
    """Exactly on boundaries: poles, cube edges and corners, the sphere itself, straight up and down, up = forward."""
    scene = {**draw_planet(rng, (1e3, 6.371e6)), **draw_light(rng)}
    zenith = [float(x) for x in rng.integers(-1, 2, 3)]
    if not any(zenith):
        zenith = [0.0, 0.0, 1.0]
    forward = [-x for x in zenith] if rng.random() < 0.4 else [float(x) for x in rng.integers(-1, 2, 3)]
    if not any(forward):
        forward = [1.0, 0.0, 0.0]
    up = forward if rng.random() < 0.5 else unit(rng)
    camera = {
        "zenith": zenith,
        "clearance_m": float(rng.choice([0.01, 0.0, 1.0, 1e5, 1e9])),
        "forward": forward,
        "up": up,
        "fov_y_deg": float(rng.choice([20.0, 60.0, 150.0])),
    }
    return {"scene": scene, "camera": camera, "size": [64, 36], "quality": "medium", "time_s": 0.0}


PLANETS = ("asteroid", "earth", "hazy", "mars", "moon", "small")
PARTS: Mapping[str, type] = {"atmosphere": Atmosphere, "clouds": Clouds, "ocean": Ocean, "terrain": Terrain}
TIMES_S = (0.0, 1.0, 1e4, 1e6, 1e8)


def _draw_whole(rng: np.random.Generator) -> Case:
    """A preset with all it has or without some of it, from anywhere, at any time, lit from anywhere."""
    camera = draw_camera(rng, tele=False)
    if rng.random() < 0.1:
        camera["up"] = camera["forward"]  # no up at all
    return {
        "planet": str(rng.choice(PLANETS)),
        "without": [name for name in PARTS if rng.random() < 0.15],
        "camera": camera,
        "sun": {"direction": unit(rng), "angular_radius_rad": float(rng.choice([1e-4, 0.004675, 0.05]))},
        "time_s": float(rng.choice(TIMES_S)),
        "size": _SIZES[int(rng.integers(len(_SIZES)))],
        "quality": str(rng.choice(["low", "medium", "high"])),
        "backend": str(rng.choice(["grid", "grid", "quadtree", "icosphere"])),
    }


def _check_whole(case: Case, session: Session) -> Found:
    """Finite, without an OpenGL error, and the same geometry once more; as a frame of a sequence too."""
    found = Found()
    scene = preset_scene(case["planet"], clouds=True)
    for name in case["without"]:
        if scene.planet.has(PARTS[name]):
            scene.planet.remove(PARTS[name])
    moment, radius_rad = case["time_s"], case["sun"]["angular_radius_rad"]
    sun = Sun(direction=tuple(case["sun"]["direction"]), angular_radius_rad=radius_rad, irradiance=scene.sun.irradiance)
    with session.renderer(
        scene, tuple(case["size"]), case["quality"], {"terrain.backend": case["backend"]}
    ) as renderer:
        camera = build_camera(scene, case["camera"])
        target = renderer.ctx.simple_framebuffer(renderer.size)
        for _ in range(2):  # as a game draws it, from the very first frame on
            renderer.render_to(target, camera, time_s=moment, sun=sun, dt_s=1.0 / 60.0)
            _no_error(found, renderer)
        renderer.gpu.leave(target)
        target.release()
        out = renderer.render(camera, time_s=moment, sun=sun, outputs=OUTPUTS)
        check_outputs(found, out)
        again = renderer.render(camera, time_s=moment, sun=sun, outputs=OUTPUTS)
        if case["backend"] == "grid":  # tiles of the others stream in
            same = all(out[name].tobytes() == again[name].tobytes() for name in ("position", "surface"))
            found.expect(same, "another picture of the same thing differs")
        _no_error(found, renderer)
    scene.release()
    return found


def _no_error(found: Found, renderer: Renderer) -> None:
    error = renderer.ctx.error
    found.expect(error == "GL_NO_ERROR", f"OpenGL error {error}")


KINDS: Mapping[str, Kind] = {
    "picture": Kind(_draw_picture, _check_picture, 3.0),
    "flight": Kind(_draw_flight, _check_flight, 1.0),
    "boundary": Kind(_draw_boundary, _check_picture, 1.0),
    "whole": Kind(_draw_whole, _check_whole, 2.0),
}
