"""Scenes of all that there can be, for hypothesis: each knob from its own range."""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import strategies as st

import planetfall as pf
from planetfall.engine.settings import PresetError, SettingError, rules_of
from planetfall.scene.kinds import PLANET_KINDS, SCENE_KINDS

TEXT = st.text(st.characters(codec="utf-8"), max_size=12)
_SKIPPED = {"height_map", "color_map", "cover_map"}
"""Knobs that name files."""
_ALWAYS = ("planet", "sun", "exposure", "composite")
"""What every scene has once it is loaded."""


def value_of(rule: Any) -> st.SearchStrategy[Any]:
    """Anything that a knob takes, but functions and files."""
    low, high = rule.knob.low, rule.knob.high
    number = st.floats(low, high, allow_nan=False, allow_infinity=False)
    if rule.kind == "float":
        found = number
    elif rule.kind == "int":
        found = st.integers(low, high)
        if rule.knob.power_of_two:
            found = st.integers(int(low).bit_length() - 1, int(high).bit_length() - 1).map(lambda n: 1 << n)
    elif rule.kind == "bool":
        found = st.booleans()
    elif rule.kind == "str":
        found = st.sampled_from(rule.knob.choices + rule.knob.aliases) if rule.knob.choices else TEXT
    elif rule.kind == "vector":
        place = (st.floats(-90.0, 90.0), st.floats(-360.0, 360.0))
        found = st.tuples(*(place if rule.knob.widget == "place" else [number] * rule.length))
        found = found.filter(any) if rule.knob.nonzero else found
    elif rule.kind == "rows":
        found = st.lists(st.tuples(*[st.integers(low, high)] * rule.length), max_size=3).map(tuple)
    elif rule.kind == "list":
        found = st.lists(component(rule.schema), max_size=2).map(tuple)
    elif rule.kind == "tables":
        inner = {name: value_of(r) for name, r in rules_of(rule.table).items()}
        made = st.builds(rule.table, **inner)
        found = st.lists(made, min_size=int(low), max_size=min(int(high), int(low) + 2)).map(tuple)
    else:
        found = st.none()
    return st.one_of(st.none(), found) if rule.optional else found


def changes(kind: type) -> st.SearchStrategy[dict[str, Any]]:
    """Some of a component's knobs."""
    rules = {n: r for n, r in rules_of(kind).items() if r.kind != "function" and n not in _SKIPPED}
    return st.fixed_dictionaries({}, optional={name: value_of(rule) for name, rule in rules.items()})


def component(kind: type) -> st.SearchStrategy[Any]:
    """One with some of its knobs turned, as far as they go together."""
    return changes(kind).map(lambda some: _turned(kind(), some))


def _turned(part: Any, some: dict[str, Any]) -> Any:
    for name, value in some.items():
        try:
            setattr(part, name, value)
        except SettingError:  # what its own check refuses
            continue
    return part


@st.composite
def scenes(draw: Any) -> pf.Scene:
    """A preset with knobs turned, parts taken off and put on, objects, and companions with the same of their own."""
    scene = pf.load_scene(draw(st.sampled_from(["earth", "moon", "mars", "hazy", "small", "woods", "earth_moon"])))
    scene.name, scene.about = draw(TEXT.filter(bool)), draw(TEXT)
    _change(draw, scene, PLANET_KINDS)
    _change(draw, scene, SCENE_KINDS)
    _add_props(draw, scene)
    for number in range(draw(st.integers(0, 2))):
        orbit = _turned(pf.Orbit(distance_m=1e9 * (1 + 10 * number)), draw(changes(pf.Orbit)))
        try:
            name = draw(TEXT)
            own = scene.companions.add(draw(st.sampled_from(["moon", "mars"])), orbit, name=name).scene
        except pf.SceneError:  # a name twice, an orbit through a planet
            continue
        _change(draw, own, PLANET_KINDS)
        _add_props(draw, own)
    return scene


def _change(draw: Any, scene: pf.Scene, kinds: dict[str, type]) -> None:
    """Turns knobs, one by one, and takes back what does not fit to the rest."""
    whole = scene.accompanies or scene
    for table, kind in kinds.items():
        handle = scene.planet if kinds is PLANET_KINDS else scene.environment
        here = draw(st.sampled_from(["as it is", "turned", "turned", "gone", "new"]))
        before = handle.get(kind)
        if here == "gone" and before is not None and table not in _ALWAYS:
            handle.remove(kind)
            _undone_unless_whole(whole, lambda handle=handle, before=before: handle.add(before))
        if here == "new" and before is None:
            try:
                handle.add(kind())
            except SettingError:
                continue
            _undone_unless_whole(whole, lambda handle=handle, kind=kind: handle.remove(kind))
        part = handle.get(kind)
        for name, value in (draw(changes(kind)) if here == "turned" and part is not None else {}).items():
            old = {n: getattr(part, n) for n in rules_of(kind)}
            try:
                setattr(part, name, value)
                whole.validate()
            except (SettingError, ValueError):
                for n, v in old.items():
                    if getattr(part, n) != v:
                        setattr(part, n, v)


def _undone_unless_whole(scene: pf.Scene, undo: Any) -> None:
    try:
        scene.validate()
    except (SettingError, PresetError):
        undo()


def _add_props(draw: Any, scene: pf.Scene) -> None:
    for _ in range(draw(st.integers(0, 2))):
        parts = [_turned(pf.Transform(), {k: v for k, v in draw(changes(pf.Transform)).items() if k != "planet"})]
        parts[0].planet = draw(st.sampled_from(["", scene.planet.name]))
        shape = {k: v for k, v in draw(changes(pf.Shape)).items() if k != "form"}
        parts.append(_turned(pf.Shape(draw(st.sampled_from(["sphere", "box"]))), shape))
        scene.add(*parts[: draw(st.integers(0, 2))], name=draw(TEXT))


def told(scene: pf.Scene) -> dict[str, Any]:
    """Everything of a scene, as plain data; what two equal scenes have in common."""

    def parts(handle: Any) -> dict[str, Any]:
        return {type(c).__name__: {n: _plain(getattr(c, n)) for n in rules_of(type(c))} for c in handle.components()}

    props = []
    for prop in scene.props:
        found = parts(prop)
        if "Transform" in found:
            found["Transform"]["planet"] = ""  # by its name or without, the same planet
        props.append((prop.name, found))
    return {
        "preset": scene.preset, "planet": parts(scene.planet), "props": props,
        **({"name": scene.name, "about": scene.about, "environment": parts(scene.environment)}
           if scene.accompanies is None else {}),
        "companions": [(c.name, {n: _plain(getattr(c.orbit, n)) for n in rules_of(pf.Orbit)}, told(c.scene))
                       for c in scene.companions.values()],
    }  # fmt: skip


def _plain(value: Any) -> Any:
    if isinstance(value, tuple):
        return [_plain(each) for each in value]
    if hasattr(value, "__dataclass_fields__"):
        return {name: _plain(getattr(value, name)) for name in rules_of(type(value))}
    # 0.0 and -0.0 are told apart.
    return float(value).hex() if isinstance(value, float) and np.isfinite(value) else value
