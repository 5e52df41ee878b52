"""The demo's command line: free flight in a window, or, without a display, the descent as pictures and a video."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

import planetfall as pf

console = Console()


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the demo; returns the exit code: 2 for an error that the message explains."""
    options = parse(arguments)
    try:
        if options.headless or not pf.has_display():
            return render_flight(options)
        return fly(options)
    except KeyboardInterrupt:
        console.print("stopped; the next start goes on here" if options.headless else "stopped")
        return 130
    except pf.expected_errors() as error:
        console.print(f"demo: {error}", style="red", markup=False, soft_wrap=True)
        return 2


def parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="demo_planet", description=__doc__)
    parser.add_argument("planet", nargs="?", default="earth", help="a planet's name, or a scene's TOML file")
    parser.add_argument("--view", help="start at a named view (window)")
    parser.add_argument("--window", choices=("glfw", "pyglet"), default="glfw", help="library that opens the window")
    parser.add_argument("--headless", action="store_true", help="render the flight although there is a display")
    parser.add_argument("--path", default="descent", help="the flight to render (headless): descent or low")
    parser.add_argument("--count", type=int, default=240, help="number of pictures (headless)")
    parser.add_argument("--size", default=None, help="width x height; 1280x720 for a window, 640x360 for pictures")
    parser.add_argument("--quality", help="low, medium, high, ultra, reference or paper; what the machine bears")
    parser.add_argument("--output", "-o", type=Path, default=Path("flight"), help="folder of the pictures (headless)")
    parser.add_argument("--force", action="store_true", help="make pictures again that are there already")
    parser.add_argument("--no-video", action="store_true", help="pictures only")
    options = parser.parse_args(arguments)
    try:
        options.size = size_of(options.size)
    except ValueError:
        parser.error(f"--size: expected width x height such as 640x360, found {options.size!r}")
    if options.count < 1:
        parser.error(f"--count: expected at least 1, found {options.count}")
    return options


def size_of(text: str | None) -> tuple[int, int] | None:
    if text is None:
        return None
    width, height = (int(part) for part in text.lower().split("x"))
    if width < 1 or height < 1:
        raise ValueError
    return width, height


def fly(options: argparse.Namespace) -> int:
    scene = pf.load_scene(options.planet)
    start = pf.view(options.view, scene.planet) if options.view else None
    pf.fly(scene, start, size=options.size or (1280, 720), quality=options.quality, window=options.window)
    return 0


def render_flight(options: argparse.Namespace) -> int:
    """The flight as numbered pictures, a contact sheet and a video; ends by naming the files."""
    scene = pf.load_scene(options.planet)
    columns = (TextColumn("rendering"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TimeRemainingColumn())
    why = "" if options.headless else "no display: "
    folder = options.output.resolve()
    console.print(f"{why}rendering the flight {options.path!r} over {scene.name} into {folder}", soft_wrap=True)
    with Progress(*columns, console=console) as bar:
        task = bar.add_task("frames", total=options.count)
        made = pf.record(
            scene,
            options.path,
            options.output,
            count=options.count,
            size=options.size or (640, 360),
            quality=options.quality or "medium",
            video=not options.no_video,
            force=options.force,
            progress=lambda done, count: bar.update(task, completed=done, total=count),
        )
        bar.update(task, completed=options.count)
    lines = [("frames", f"{made.frames[0].resolve()} ... {made.frames[-1].name}")]
    written = (("contact sheet", made.sheet), ("video", made.video))
    lines += [(what, str(file.resolve())) for what, file in written if file is not None]
    for what, file in lines:
        console.print(f"{what:14}{file}", highlight=False, markup=False, soft_wrap=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
