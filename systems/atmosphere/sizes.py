"""From quality knobs to sizes of tables."""

from __future__ import annotations

from ...engine.settings import Settings
from .job import MakesTables
from .paper import PaperSizes
from .tables import Directions, TableSizes
from .views import ViewSizes

__all__ = ["method_sizes", "paper_sizes", "table_sizes", "view_sizes"]


def table_sizes(settings: Settings) -> TableSizes:
    """Sizes of the tables that hold for all cameras, from the keys "atmosphere.*"."""
    altitudes, azimuths = int(settings["atmosphere.altitudes"]), int(settings["atmosphere.directions"])
    march = int(settings["atmosphere.march"])
    return TableSizes(
        depth=(4 * altitudes, 3 * altitudes),
        depth_segments=24,
        moments=(int(settings["atmosphere.sun_heights"]), altitudes),
        degree=int(settings["atmosphere.degree"]),
        orders=int(settings["atmosphere.orders"]),
        # The first order has the sun's aureole in it: three times as many azimuths.
        first=Directions(2 * azimuths, -(-5 * azimuths // 4), 3 * azimuths, march),
        later=Directions(-(-5 * azimuths // 4), -(-3 * azimuths // 4), azimuths, march),
    )


def view_sizes(settings: Settings) -> ViewSizes:
    """Sizes of the tables of one camera."""
    return ViewSizes(*(int(settings[f"atmosphere.{name}"]) for name in ("columns", "rows", "slices")))


def paper_sizes(settings: Settings, orders: int = 4) -> PaperSizes:
    """Sizes of the tables of the printed method: the source's own, times the knob "atmosphere.paper_scale"."""
    scale = float(settings["atmosphere.paper_scale"])

    def part(size: int, least: int) -> int:
        return max(least, 2 * round(0.5 * size * scale))

    return PaperSizes(
        transmittance=(part(256, 32), part(64, 16)),
        scattering=(part(32, 8), part(128, 16), part(32, 8), 8 if scale > 0.3 else 4),
        irradiance=(part(64, 16), part(16, 8)),
        orders=orders,
        storage="rgba32f",
    )


_SIZES = {"ours": table_sizes, "paper": paper_sizes}


def method_sizes(method: str, settings: Settings) -> MakesTables:
    """Sizes of the tables of one of Atmosphere.method."""
    return _SIZES[method](settings)
