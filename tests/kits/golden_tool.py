"""Takes, refreshes and shows the golden pictures. Run it from a checkout:

    python tests/kits/golden_tool.py --update            every golden picture that has changed
    python tests/kits/golden_tool.py --update earth/near knobs
    python tests/kits/golden_tool.py --sheet goldens.png contact sheet of the files as they are
    python tests/kits/golden_tool.py --compare           how far this driver's pictures are from the files; writes none
    python tests/kits/golden_tool.py --measure           the table of docs/testing.md: what FLIP says to which change

Names may be a picture's, the beginning of one, or nothing for all.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from golden_compare import SAME, Likeness, likeness, read_picture, write_picture
from golden_pictures import FOLDER, GOLDENS, VIEW_SIZE, Picture, Pixels, Studio
from rich.console import Console

import planetfall as pf
from planetfall.systems.capture import contact_sheet, write_png

console = Console()

MEASURED_VIEWS = ("space", "orbit", "coast", "near", "ground", "beach")

MACHINES: dict[str, Mapping[str, str]] = {
    "the same again": {},
    "one thread": {"LP_NUM_THREADS": "1"},
    "vectors of 128 bits": {"LP_NATIVE_VECTOR_WIDTH": "128"},
    "CPU without FMA and AVX": {"GALLIUM_OVERRIDE_CPU_CAPS": "sse4.1"},
    "depth written by fragments": {"MESA_EXTENSION_OVERRIDE": "-GL_ARB_clip_control"},
}
"""Other machines, as far as Mesa's software renderer can play them: environment of a process of its own."""


def chosen(names: Sequence[str]) -> list[Picture]:
    """The goldens that are named, or whose names begin so; SystemExit for a name that fits none."""

    def fits(picture: Picture, name: str) -> bool:
        return picture.name == name or picture.name.startswith(name.rstrip("/") + "/")

    for name in names:
        if not any(fits(p, name) for p in GOLDENS):
            raise SystemExit(f"no golden picture {name!r}; there are: {', '.join(p.name for p in GOLDENS)}")
    return [p for p in GOLDENS if not names or any(fits(p, name) for name in names)]


def update(names: Sequence[str]) -> None:
    """Write the pictures whose pixels or settings have changed; files of pictures that are gone are deleted."""
    started, changed = time.perf_counter(), 0
    with Studio() as studio:
        for picture in chosen(names):
            pixels = studio.take(picture)
            if picture.path.is_file():
                before = read_picture(picture.path)
                if before.shape == pixels.shape and np.array_equal(before, pixels):
                    continue
                how = str(likeness(before, pixels)) if before.shape == pixels.shape else "another size"
            else:
                how = "new"
            write_picture(picture.path, pixels, picture.settings() | studio.machine)
            changed += 1
            print_plain(f"{picture.name}: {how}")
    if not names:
        for path in set(FOLDER.rglob("*.png")) - {p.path for p in GOLDENS}:
            path.unlink()
            print_plain(f"{path.relative_to(FOLDER)}: deleted, no such picture any more")
    total = sum(path.stat().st_size for path in FOLDER.rglob("*.png"))
    seconds = time.perf_counter() - started
    print_plain(f"{changed} written in {seconds:.0f} s; {FOLDER} holds {total / 1e6:.2f} MB. Look at them: --sheet")


def compare(names: Sequence[str]) -> None:
    """A line of each picture that differs from its file on this driver, and how many there are."""
    differing = over = taken = 0
    with Studio() as studio:
        for picture in chosen(names):
            found, limit = likeness(read_picture(picture.path), studio.take(picture)), picture.allowed or SAME
            taken += 1
            if found.worst > 0.0:
                differing += 1
                over += not found.within(limit)
                print_plain(f"{picture.name}: {found}")
        renderer = studio.machine["renderer"]
    print_plain(f"{renderer}: {taken} pictures, {differing} differ, {over} beyond {SAME} or a limit of their own")


def sheet(path: Path, names: Sequence[str]) -> None:
    """A contact sheet of the files."""
    pictures = [(p.name, p.path) for p in chosen(names) if p.path.is_file()]
    write_png(path, contact_sheet(pictures, columns=5, thumb_width=VIEW_SIZE[0]))
    print_plain(f"{path}: {len(pictures)} pictures")


def take_views(path: Path) -> None:
    """The measured views of earth into an .npz; run in a process of its own by `measure`."""
    with Studio() as studio:
        pictures: dict[str, Any] = {view: studio.take(Picture(view, "earth", view)) for view in MEASURED_VIEWS}
    np.savez(path, **pictures)


def measure() -> None:
    """What FLIP says to other machines, and to changes that have to be noticed."""
    rows: list[str] = []
    with tempfile.TemporaryDirectory() as folder:
        taken: dict[str, Mapping[str, Pixels]] = {}
        for name, environment in MACHINES.items():
            path = Path(folder) / f"{len(taken)}.npz"
            command = [sys.executable, __file__, "--take", str(path)]
            subprocess.run(command, check=True, env={**os.environ, **environment}, stderr=subprocess.DEVNULL)
            with np.load(path) as data:
                taken[name] = dict(data)
    base = taken["the same again"]
    with Studio() as studio:
        plain = {view: studio.take(Picture(view, "earth", view)) for view in MEASURED_VIEWS}
        for name, pictures in taken.items():
            rows.append(_row(name, [likeness(plain[view], pictures[view]) for view in MEASURED_VIEWS]))
        for name, change in _changes().items():
            rows.append(_row(name, [likeness(base[view], change(studio, view, base[view])) for view in MEASURED_VIEWS]))
    print_plain("| change | mean | 99.9th percentile | worst pixel | noticed |\n|---|---|---|---|---|")
    print_plain("\n".join(rows))
    print_plain(f"limits: {SAME}; views {', '.join(MEASURED_VIEWS)} of earth at {VIEW_SIZE[0]} x {VIEW_SIZE[1]}")


def _row(name: str, found: Sequence[Likeness]) -> str:
    """A line of a Markdown table: least to most over the views."""
    cells = [
        f"{min(values):.{digits}f} - {max(values):.{digits}f}"
        for values, digits in (
            ([f.mean for f in found], 5), ([f.p999 for f in found], 4), ([f.worst for f in found], 3)
        )
    ]  # fmt: skip
    return f"| {name} | {' | '.join(cells)} | {sum(not f.within(SAME) for f in found)} of {len(found)} |"


def print_plain(text: str) -> None:
    console.print(text, markup=False, highlight=False, soft_wrap=True)


Change = Callable[[Studio, str, Pixels], Pixels]


def _changes() -> dict[str, Change]:
    """Changes to the picture of a view, from hardly visible to plain."""

    def changed(**parts: Any) -> Change:
        return lambda studio, view, _: studio.take(replace(Picture(view, "earth", view), **parts))

    def turned(pixels: float) -> Change:
        def take(studio: Studio, view: str, _: Pixels) -> Pixels:
            shown = pf.view(view, "earth")
            fixed = {"exposure.mode": "fixed", "exposure.ev100": shown.ev100}
            angle = pixels * shown.fov_y_deg / VIEW_SIZE[1]
            return studio.take(Picture(view, "earth", view, changes=fixed, free=True, turned_deg=angle))

        return take

    def painted(rows: slice, columns: slice, colour: int) -> Change:
        def paint(_studio: Studio, _view: str, pixels: Pixels) -> Pixels:
            copy = pixels.copy()
            copy[rows, columns] = colour
            return copy

        return paint

    def scaled(factor: float) -> Change:
        return lambda _s, _v, pixels: np.clip(np.round(pixels * factor), 0, 255).astype(np.uint8)

    return {
        "brighter by 1 %": scaled(1.01),
        "brighter by 3 %": scaled(1.03),
        "one pixel black": painted(slice(130, 131), slice(160, 161), 0),
        "3 x 3 pixels black": painted(slice(130, 133), slice(160, 163), 0),
        "a crack: one column, 40 pixels, black": painted(slice(110, 150), slice(160, 161), 0),
        "one white pixel": painted(slice(130, 131), slice(160, 161), 255),
        "camera turned by 0.0001 px": turned(0.0001),
        "camera turned by 0.02 px": turned(0.02),
        "camera turned by 0.1 px": turned(0.1),
        "sun 0.1 degree higher": changed(sun_higher_deg=0.1),
        "sun 1 degree higher": changed(sun_higher_deg=1.0),
        "terrain.edge_px 15 to 5": changed(overrides={"terrain.edge_px": 5.0}),
        "terrain.layers 16 to 15": changed(changes={"terrain.layers": 15}),
        "composite.bloom 0.010 to 0.012": changed(changes={"composite.bloom": 0.012}),
        "ocean.absorption_per_m 5 % more": changed(changes={"ocean.absorption_per_m": (0.3675, 0.0735, 0.0315)}),
        "another seed": changed(changes={"terrain.seed": 2}),
    }


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", help="golden pictures, or the beginnings of their names")
    parser.add_argument("--update", action="store_true", help="write the golden pictures")
    parser.add_argument("--sheet", type=Path, help="write a contact sheet of the golden pictures")
    parser.add_argument("--compare", action="store_true", help="print how far this driver is from the files")
    parser.add_argument("--measure", action="store_true", help="print what FLIP says to which change (2 minutes)")
    parser.add_argument("--take", type=Path, help=argparse.SUPPRESS)
    given = parser.parse_args(arguments)
    if given.take:
        take_views(given.take)
    if given.update:
        update(given.names)
    if given.compare:
        compare(given.names)
    if given.sheet:
        sheet(given.sheet, given.names)
    if given.measure:
        measure()
    if not (given.take or given.update or given.compare or given.sheet or given.measure):
        parser.print_help()


if __name__ == "__main__":
    main()
