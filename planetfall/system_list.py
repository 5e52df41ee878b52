"""The library's own systems."""

from __future__ import annotations

from .engine.system import System
from .systems.atmosphere.system import AtmosphereSystem
from .systems.clouds.methods import CloudMethods
from .systems.composite import CompositeSystem
from .systems.debug import DebugSystem
from .systems.gbuffer import GBufferSystem
from .systems.light import LightSystem
from .systems.ocean import OceanSystem
from .systems.props import PropsSystem
from .systems.proxy import ProxySystem
from .systems.shadows.system import ShadowSystem
from .systems.sky import SkySystem, StarsSystem
from .systems.terrain.system import TerrainSystem

__all__ = ["SYSTEMS"]

SYSTEMS: tuple[type[System], ...] = (
    ProxySystem,
    LightSystem,
    GBufferSystem,
    AtmosphereSystem,
    TerrainSystem,
    ShadowSystem,
    OceanSystem,
    PropsSystem,
    SkySystem,
    StarsSystem,
    CloudMethods,
    CompositeSystem,
    DebugSystem,
)  # fmt: skip
"""In the order of their updates; the order of the passes comes from the graph."""
