"""`planetfall planets`, `views` and `graph`: what there is, and how a frame is made."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from rich.console import Console
from rich.table import Column, Table

from ..errors import OutputError
from ..systems.capture import require_writable, written_beside
from .options import Planet, Quality, Set, Size, parse_overrides, parse_size
from .progress import written
from .render import DEFAULT_VIEW, find_view, views_for

__all__ = ["graph_command", "planets_command", "views_command"]

console = Console()

_BLOCK = re.compile(r"(<!-- frame graph\b[^\n]*-->\n).*?(<!-- /frame graph -->)", re.DOTALL)
_WIDE = 140
"""Columns of a window that has room for what each pass reads and writes."""


def planets_command() -> None:
    """List the planets."""
    from .. import load_scene, planets
    from ..scene.file import describe, scenes

    table = Table("planet", "radius", "highest", "has", "about", box=None)
    for name in planets():
        with load_scene(name) as scene:
            parts = scene.planet.components()
            highest = max((getattr(part, "highest_m", 0.0) for part in parts), default=0.0)
            has = ", ".join(type(part).__name__.lower() for part in parts if type(part).__name__ != "Planet")
            radius = scene.planet.radius_m
            table.add_row(name, f"{radius / 1e3:,.0f} km".replace(",", " "), f"{highest:,.0f} m", has, scene.about)
    console.print(table)
    for name in scenes():
        found = describe(name)
        several = ", ".join([found.name, *(told.name for told, _ in found.companions)])
        console.print(f"{name}: {found.about} ({several})", highlight=False, soft_wrap=True)


def views_command(planet: Planet = "earth") -> None:
    """List the named views that make sense for a planet."""
    from .. import load_scene

    with load_scene(planet) as scene:
        table = Table("view", "about", box=None)
        for name in views_for(scene):
            table.add_row(name, str(getattr(find_view(name, scene), "about", "")))
        console.print(table)


def graph_command(
    planet: Planet = "earth",
    *,
    view: str = DEFAULT_VIEW,
    explain: str | None = None,
    passes: Annotated[bool, Parameter(negative="")] = False,
    barriers: Annotated[bool, Parameter(negative="")] = False,
    size: Size = "640x360",
    quality: Quality = "high",
    overrides: Set = (),
    output: Annotated[Path | None, Parameter(name=["--output", "-o"])] = None,
    into: Path | None = None,
) -> None:
    """Show the frame graph of a view: as a mermaid diagram, or what one pass does and why it runs.

    Parameters
    ----------
    view
        The view whose frame is shown.
    explain
        Name of a pass: what it reads and writes, who needs it, why it runs.
    passes
        A table of what ran, with times and memory, in place of the diagram.
    barriers
        The storage barriers in running order, with the accesses that each keeps apart, in place of the diagram.
    output
        Write the diagram into this file.
    into
        Put the diagram into this Markdown file, between its two comment lines `frame graph` and `/frame graph`.
    """
    if into is not None and (explain is not None or passes or barriers or output is not None):
        raise OutputError("--into takes the diagram: leave out --explain, --passes, --barriers and --output")
    document = "" if into is None else _document(into)
    if output is not None:
        require_writable(output)
    pixels, knobs = parse_size(size), parse_overrides(overrides)
    from .. import load_scene

    scene = load_scene(planet)
    shot = find_view(view, scene)
    from ..render.renderer import Renderer

    with Renderer(scene, pixels, quality, knobs) as renderer:
        for _ in range(3 if passes else 1):  # the first frame compiles shaders: no time to show
            renderer.render(shot)
        if explain is not None:
            text = renderer.graph.explain(explain)
        elif passes:
            console.print(pass_table(renderer.passes(), console.width))
            if console.width < _WIDE:
                console.print(f"What they read and write: --explain PASS, or a window of {_WIDE} columns.", style="dim")
            return
        else:
            text = renderer.graph.analysis.to_barriers() if barriers else renderer.graph.to_mermaid()
    if into is not None:
        block = f"```mermaid\n{text.rstrip()}\n```\n"
        output, text = into, _BLOCK.sub(lambda found: found[1] + block + found[2], document).removesuffix("\n")
    if output is None:
        console.print(text, markup=False, highlight=False, soft_wrap=True)
        return
    with written_beside(output) as beside:
        beside.write_text(text + "\n", encoding="utf-8")
    written(output)


def _document(file: Path) -> str:
    """A Markdown file that has a place for the diagram. OutputError when it is missing or has none."""
    if not file.is_file():
        raise OutputError(f"--into: there is no file {str(file)!r} to put the diagram into")
    require_writable(file)
    text = file.read_text(encoding="utf-8")
    if not _BLOCK.search(text):
        raise OutputError(
            f"--into: {str(file)!r} has no place for the diagram: expected a line <!-- frame graph --> and below it"
            " a line <!-- /frame graph -->"
        )
    return text


def pass_table(reports: list, width: int) -> Table:
    """What ran; names of what each pass reads and writes only where `width` columns have room for them."""
    wide = width >= _WIDE
    name = Column("pass", no_wrap=True)
    table = Table(name, "CPU ms", "GPU ms", "MB", *(("reads", "writes") if wide else ()), "skipped", box=None)
    for report in reports:
        gpu = "" if report.gpu_ms is None else f"{report.gpu_ms:.2f}"
        linked = (" ".join(report.reads), " ".join(report.writes)) if wide else ()
        table.add_row(
            report.name, f"{report.cpu_ms:.3f}" if report.ran else "", gpu, f"{report.bytes / 1e6:.1f}", *linked,
            report.skipped_why or "",
        )  # fmt: skip
    return table
