"""The gallery: the best pairs of planet and view as small JPEGs, with a page that shows them; resumable."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

from .._version import __version__
from ..camera.views import view
from ..scene.scene import load_scene
from ..systems.capture import read_jpeg_settings, require_writable, write_jpeg, written_beside
from .shot import made_of

__all__ = ["BEST", "Shown", "best_gallery"]

BEST: tuple[tuple[str, str], ...] = (
    ("earth", "orbit"),
    ("earth", "cloud_shadows"),
    ("earth", "meadow"),
    ("earth", "forest"),
    ("earth", "ground"),
    ("earth", "lakeside"),
    ("earth", "waterfall"),
    ("earth", "beach"),
    ("earth", "fair"),
    ("earth", "dusk"),
    ("earth", "space"),
    ("mars", "valley"),
    ("moon", "ground"),
    ("hazy", "limb"),
    ("small", "coast"),
    ("asteroid", "orbit"),
)
"""Planet and view, in the order of the page."""
INDEX = "README.md"

_HEAD = """# Gallery

Written by `planetfall gallery --best`: sixteen pairs of planet and view, settled. All other views of a planet:
`planetfall gallery mars`, at 640 x 360 unless told otherwise.
"""


@dataclass(frozen=True)
class Shown:
    """What `best_gallery` wrote."""

    page: Path
    pictures: list[Path]
    made: int
    """Of the pictures; the others were there already, of the same settings."""


def best_gallery(
    folder: str | PathLike[str],
    *,
    pairs: Sequence[tuple[str, str]] = BEST,
    size: tuple[int, int] = (1280, 720),
    quality: str = "ultra",
    overrides: Mapping[str, Any] | None = None,
    force: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> Shown:
    """Render pairs of (planet, view) into `folder` (made when missing), and a page README.md that shows them all.

    Pictures of the same settings that are there are kept, so that an interrupted gallery goes on; `force` makes all
    again. progress(done, count) follows the pictures that are made. UnknownNameError for a planet or a view that there
    isn't, before anything is rendered.
    """
    folder = require_writable(Path(folder), make_folder=True)
    texts, scenes = {}, {}
    for planet, name in pairs:
        scene = load_scene(planet)
        texts[planet, name] = view(name, scene.planet).about
        scenes[planet] = made_of(scene)
        scene.release()
    files = {pair: folder / f"{pair[0]}-{pair[1]}.jpg" for pair in pairs}
    settings = {
        pair: {
            "planetfall": __version__, "planet": pair[0], "view": pair[1], "size": list(size), "quality": quality,
            "overrides": dict(overrides or {}), "made_of": scenes[pair[0]],
        }
        for pair in pairs
    }  # fmt: skip
    todo = [pair for pair in pairs if force or not _is_there(files[pair], settings[pair])]
    for done, pair in enumerate(todo, 1):
        _render(pair, files[pair], settings[pair], size)
        if progress is not None:
            progress(done, len(todo))
    page = folder / INDEX
    with written_beside(page) as beside:
        beside.write_text(_page(pairs, texts, size, quality), encoding="utf-8")
    return Shown(page, list(files.values()), len(todo))


def _render(pair: tuple[str, str], file: Path, settings: Mapping[str, Any], size: tuple[int, int]) -> None:
    from ..render.renderer import Renderer

    scene = load_scene(pair[0])
    with Renderer(scene, size, settings["quality"], settings["overrides"]) as renderer:
        seen = view(pair[1], scene.planet)
        renderer.settle(seen)
        write_jpeg(file, renderer.render(seen)["color"], settings)
    scene.release()


def _is_there(file: Path, settings: Mapping[str, Any]) -> bool:
    return file.exists() and read_jpeg_settings(file) == json.loads(json.dumps(settings))


def _page(
    pairs: Sequence[tuple[str, str]], texts: Mapping[tuple[str, str], str], size: tuple[int, int], quality: str
) -> str:
    parts = [_HEAD]
    for planet, name in pairs:
        about = texts[planet, name]
        command = f"planetfall render {planet} --view {name} --quality {quality} --size {size[0]}x{size[1]}"
        parts.append(
            f"## {planet}, {name}\n\n{about[:1].upper()}{about[1:]}.\n`{command}`\n\n"
            f"![{planet}, {name}]({planet}-{name}.jpg)\n"
        )
    return "\n".join(parts)
