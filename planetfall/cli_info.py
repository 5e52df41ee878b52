"""`planetfall planets`, `views` and `graph`: what there is, and how a frame is made."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from rich.console import Console
from rich.table import Table

from .cli_options import Planet, Quality, Set, Size, parse_overrides, parse_size
from .cli_render import DEFAULT_VIEW, find_view, views_for
from .systems.capture import require_writable, written_beside

__all__ = ["graph_command", "planets_command", "views_command"]

console = Console()


def planets_command() -> None:
    """List the planets."""
    from . import load_scene, planets

    table = Table("planet", "radius", "highest", "has", "about", box=None)
    for name in planets():
        with load_scene(name) as scene:
            parts = scene.planet.components()
            highest = max((getattr(part, "highest_m", 0.0) for part in parts), default=0.0)
            has = ", ".join(type(part).__name__.lower() for part in parts if type(part).__name__ != "Planet")
            radius = scene.planet.radius_m
            table.add_row(name, f"{radius / 1e3:,.0f} km".replace(",", " "), f"{highest:,.0f} m", has, scene.about)
    console.print(table)


def views_command(planet: Planet = "earth") -> None:
    """List the named views that make sense for a planet."""
    from . import load_scene

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
    size: Size = "640x360",
    quality: Quality = "high",
    overrides: Set = (),
    output: Annotated[Path | None, Parameter(name=["--output", "-o"])] = None,
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
    output
        Write the diagram into this file.
    """
    if output is not None:
        require_writable(output)
    pixels, knobs = parse_size(size), parse_overrides(overrides)
    from . import load_scene

    scene = load_scene(planet)
    shot = find_view(view, scene)
    from .renderer import Renderer

    with Renderer(scene, pixels, quality, knobs) as renderer:
        for _ in range(3 if passes else 1):  # the first frame compiles shaders: no time to show
            renderer.render(shot)
        if explain is not None:
            text = renderer.graph.explain(explain)
        elif passes:
            console.print(_pass_table(renderer.passes()))
            return
        else:
            text = renderer.graph.to_mermaid()
    if output is None:
        console.print(text, markup=False, highlight=False, soft_wrap=True)
        return
    with written_beside(output) as beside:
        beside.write_text(text + "\n", encoding="utf-8")
    console.print(f"wrote [bold]{output}[/]", highlight=False, soft_wrap=True)


def _pass_table(reports: list) -> Table:
    table = Table("pass", "system", "CPU ms", "GPU ms", "MB", "reads", "writes", "skipped", box=None)
    for report in reports:
        gpu = "" if report.gpu_ms is None else f"{report.gpu_ms:.2f}"
        table.add_row(
            report.name, report.system, f"{report.cpu_ms:.3f}" if report.ran else "", gpu, f"{report.bytes / 1e6:.1f}",
            " ".join(report.reads), " ".join(report.writes), report.skipped_why or "",
        )  # fmt: skip
    return table
