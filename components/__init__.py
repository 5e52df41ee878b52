"""Plain dataclasses that say what a scene is made of; knobs are field metadata. numpy at most, no GL, no logic."""

if __name__ != "planetfall.components":
    raise ImportError(
        "import planetfall.components, not components: two copies of each class would not know each other"
    )

from ._knob import Knob, Vec3, knob, knobs
from .atmosphere import Atmosphere
from .clouds import MOST_CLOUD_LAYERS, CloudLayer, Clouds
from .cover import MOST_SPECIES, Cover, CoverSpecies
from .debug_view import DebugView
from .exposure import Composite, Exposure
from .ocean import Ocean, Wave
from .orbit import Orbit
from .planet import Planet
from .props import Shape, Transform
from .quality import (
    AtmosphereQuality,
    CloudQuality,
    CompositeQuality,
    CoverQuality,
    LightQuality,
    MemoryQuality,
    OceanQuality,
    ProxyQuality,
    ShadowQuality,
    SkyQuality,
    TerrainQuality,
)
from .stars import Stars
from .sun import Sun
from .terrain import Terrain
from .wind import Wind

__all__ = [
    "MOST_CLOUD_LAYERS",
    "MOST_SPECIES",
    "Atmosphere",
    "AtmosphereQuality",
    "CloudLayer",
    "CloudQuality",
    "Clouds",
    "Composite",
    "CompositeQuality",
    "Cover",
    "CoverQuality",
    "CoverSpecies",
    "DebugView",
    "Exposure",
    "Knob",
    "LightQuality",
    "MemoryQuality",
    "Ocean",
    "OceanQuality",
    "Orbit",
    "Planet",
    "ProxyQuality",
    "ShadowQuality",
    "Shape",
    "SkyQuality",
    "Stars",
    "Sun",
    "Terrain",
    "TerrainQuality",
    "Transform",
    "Vec3",
    "Wave",
    "Wind",
    "knob",
    "knobs",
]
