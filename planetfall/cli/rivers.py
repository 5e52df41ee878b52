"""`planetfall rivers`: the largest rivers of a planet, as a table and as a map."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from rich.console import Console
from rich.table import Table

from ..errors import SettingError
from ..systems.capture import require_writable
from .options import Planet, Size, parse_size
from .progress import settling, written

__all__ = ["rivers_command"]

console = Console()


def rivers_command(
    planet: Planet = "earth",
    *,
    count: int = 12,
    size: Size = "2048x1024",
    output: Annotated[Path | None, Parameter(name=["--output", "-o"])] = None,
) -> None:
    """List the largest rivers of a planet, and draw a map of all its rivers.

    Parameters
    ----------
    count
        How many are listed.
    size
        Of the map: longitude across, latitude down.
    output
        The map, a PNG; none is drawn without.
    """
    from .. import Ocean, Terrain, latitude_longitude, load_scene
    from ..query.drainage import climate_params, network_below, rivers_of

    if output is not None:
        require_writable(output)
    pixels = parse_size(size)
    with load_scene(planet) as scene:
        if scene.planet.get(Terrain) is None:
            raise SettingError(f"rivers: {planet} has no ground")
        with settling("rivers") as progress:
            network = network_below(scene.planet, progress=progress)
        sea = "the sea" if scene.planet.get(Ocean) is not None else "low ground"
        table = Table("river", "length", "water", "catchment", "mouth", "ends in", box=None)
        for river in rivers_of(network, count):
            latitude, longitude = latitude_longitude(river.mouth)
            end = sea if river.reaches_sea else "a river" if river.into is None else f"river {river.into}"
            table.add_row(
                str(river.number), f"{river.length_m / 1e3:,.0f} km", f"{river.discharge_m3_s:,.0f} m3/s",
                f"{river.catchment_m2 / 1e6:,.0f} km2", f"{latitude:.1f}, {longitude:.1f}", end,
            )  # fmt: skip
        console.print(table)
        if output is not None:
            from ..capture.river_map import river_map
            from ..systems.capture import write_png

            write_png(
                output,
                river_map(network, pixels, climate_params(scene.planet[Terrain], scene.planet.get(Ocean) is not None)),
            )
            written(output)
