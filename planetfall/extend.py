"""What a game needs to add a feature of its own: a component with knobs, a system with passes, shaders, a debug view.

    @dataclass
    class Ring:
        outer_radii: float = knob(2.3, 1.0, 20.0, help="Outer edge")

    class RingSystem(System):
        name, needs = "ring", (Planet, Ring)
        ...

    register(Ring, RingSystem, shaders=Path(__file__).parent / "shaders", debug_views={"ring": ("ring.light", "heat")})

From then on it is as if the library had it: `scene.planet.add(Ring())`, `[ring]` in scene files, `scene.save`, a
section in the settings panel with range, unit and help of each knob, `overrides={"ring.outer_radii": 3.0}`,
`planetfall render earth --set ring.outer_radii=3`, and renderers made afterwards run its system while the component
is there. Without it nothing is set up.
docs/tutorials/write-a-system.md builds one. A material of the ground takes one call, `register_material`
(docs/tutorials/a-material-of-your-own.md).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from .components import Exposure, Planet, Sun, Terrain, knob
from .engine.frame import Frame, ViewInfo
from .engine.frame.contracts import bind_contracts, contract_reads
from .engine.gpu.program import Fullscreen
from .engine.gpu.state import State
from .engine.graph import STAGES, BufferSpec, GraphBuilder, PassIO, TextureSpec
from .engine.settings import SettingError, rules_of, with_overrides
from .engine.system import Setup, System
from .engine.world import World
from .quality import QUALITY
from .scene import kinds as _kinds
from .systems.debug import NAMED_VIEWS
from .systems.debug.views import MODES
from .systems.debug.views import View as DebugEntry
from .systems.terrain.material_list import register_material, unregister_material
from .systems.terrain.materials import Ripples

__all__ = [
    "STAGES",
    "BufferSpec",
    "Exposure",
    "Frame",
    "GraphBuilder",
    "PassIO",
    "Planet",
    "Ripples",
    "Setup",
    "Sun",
    "System",
    "Terrain",
    "TextureSpec",
    "ViewInfo",
    "bind_contracts",
    "contract_reads",
    "fullscreen_pass",
    "knob",
    "register",
    "register_material",
    "registered_systems",
    "shader_folders",
    "unregister",
    "unregister_material",
    "with_overrides",
]


@dataclass(frozen=True)
class _Extension:
    table: str
    place: str
    system: type[System] | None
    shaders: Path | None
    debug_views: Mapping[str, DebugEntry] = field(default_factory=dict)


_extensions: dict[type, _Extension] = {}


def register(
    component: type,
    system: type[System] | None = None,
    *,
    table: str = "",
    place: str = "planet",
    shaders: Path | str | None = None,
    debug_views: Mapping[str, tuple[str, str]] | None = None,
) -> None:
    """Make a component of a game's known everywhere, with the system that draws it.

    component: a dataclass whose fields are `knob(...)`. system: a System class; renderers made from now on have it.
    table: its name in scene files and overrides; "" is the class's name in snake_case. place: "planet" or "scene",
    whose component it is. shaders: a folder whose files the system names relative to it; put them into a folder of
    their own name, as in "ring/draw.frag". debug_views: {name: (resource of the graph, mode)}, the modes of
    systems/debug/views.py.

    Registering the same component again replaces what was said before. Raises SettingError, before anything is changed,
    for a taken table, folder that isn't there, unknown place or mode; TypeError for what is no dataclass.
    """
    rules_of(component)  # mistakes in the declaration, now
    table = table or re.sub(r"(?<!^)(?=[A-Z])", "_", component.__name__).lower()
    if place not in ("planet", "scene"):
        raise SettingError(f"register({component.__name__}): place: expected 'planet' or 'scene', found {place!r}")
    known = _kinds.KINDS.get(table)
    if known is not None and known is not component:
        raise SettingError(
            f"register({component.__name__}): table {table!r} belongs to {known.__name__}; give another table="
        )
    folder = None if shaders is None else Path(shaders)
    if folder is not None and not folder.is_dir():
        raise SettingError(f"register({component.__name__}): shaders: there is no folder {folder}")
    shown: dict[str, DebugEntry] = {}
    for name, (resource, mode) in (debug_views or {}).items():
        if mode and mode not in MODES:
            raise SettingError(
                f"register: debug view {name!r}: mode: expected one of {', '.join(MODES)}, found {mode!r}"
            )
        if name in NAMED_VIEWS and not any(name in e.debug_views for e in _extensions.values()):
            raise SettingError(f"register: debug view {name!r} is one of the library's; choose another name")
        shown[name] = DebugEntry(resource, mode)
    unregister(component)
    _kinds.add_kind(table, component, place)
    QUALITY.component_rules.update({f"{table}.{name}": rule for name, rule in rules_of(component).items()})
    NAMED_VIEWS.update(shown)
    _extensions[component] = _Extension(table, place, system, folder, shown)


def unregister(component: type) -> None:
    """The opposite of register; nothing happens for a component that isn't registered. Renderers that exist keep it."""
    found = _extensions.pop(component, None)
    if found is None:
        return
    _kinds.remove_kind(found.table)
    for name in rules_of(component):
        QUALITY.component_rules.pop(f"{found.table}.{name}", None)
    for name in found.debug_views:
        NAMED_VIEWS.pop(name, None)


def fullscreen_pass(io: PassIO, world: World, draw: Fullscreen, state: State, target: str) -> Callable[[], None]:
    """What `bind` of a pass that draws over the whole picture returns.

    draw: from setup.gpu.fullscreen(file); its unit 0 gets gbuffer.depth, which the pass has to read, and the shader
    contracts that it includes their textures (`contract_reads`). state: from setup.gpu.state(...). target: the
    texture of the graph that it draws into.
    """
    framebuffer, depth = io.framebuffer(colors=(target,)), io.texture("gbuffer.depth")
    bind = bind_contracts(world, io)

    def run() -> None:
        bind()
        framebuffer.use()
        state.apply()
        depth.use(0)
        draw.render()

    return run


def registered_systems() -> tuple[type[System], ...]:
    """The systems of registered components, in the order of registration."""
    return tuple(e.system for e in _extensions.values() if e.system is not None)


def shader_folders() -> tuple[Path, ...]:
    """The shader folders of registered components."""
    return tuple(dict.fromkeys(e.shaders for e in _extensions.values() if e.shaders is not None))
