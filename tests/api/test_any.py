"""`Any` in public signatures only where anything goes: values that users give, as to `retune`, and what TOML has."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LIBRARY = ("engine", "systems", "planetfall", "components")
KEYED = {"Mapping", "dict", "NDArray", "np.ndarray", "np.floating"}
"""What may hold `Any`: tables of values by name, and arrays of any kind of number."""
FORMULAS = (
    *("systems/terrain/height_", "systems/terrain/crater_form", "systems/terrain/rivers/form"),
    *("engine/surface/noise_kernels", "systems/terrain/crater_kernels", "systems/terrain/eroded_kernels"),
)
"""Their functions take whatever can be added and multiplied: numbers, arrays, and names of variables of a shader."""
KNOWN: dict[str, int] = {
    "engine/blocks/layout.py": 1,
    "engine/frame/frame.py": 1,
    "engine/gpu/gl.py": 3,
    "engine/gpu/guard_tables.py": 3,
    "engine/gpu/imgui_backend.py": 1,
    "engine/gpu/watch.py": 1,
    "engine/graph/backend.py": 4,
    "engine/graph/pass_io.py": 1,
    "engine/graph/plan.py": 1,
    "engine/hosts/native.py": 1,
    "engine/settings/check.py": 1,
    "engine/world.py": 4,
    "systems/atmosphere/views.py": 1,
    "systems/capture/png.py": 1,
    "systems/tweak/list_editor.py": 4,
    "systems/tweak/panel.py": 2,
    "systems/tweak/widgets.py": 2,
    "systems/tweak/workbench.py": 4,
    "planetfall/app/tweak_store.py": 2,
    "planetfall/camera/arguments.py": 5,
    "planetfall/camera/place.py": 5,
    "planetfall/render/snapshot.py": 1,
    "planetfall/scene/file.py": 1,
    "planetfall/scene/handle.py": 1,
    "planetfall/scene/kinds.py": 1,
    "planetfall/scene/scene.py": 2,
    "components/_knob.py": 4,
}
"""How often a file has it elsewhere, by its path. Numbers may only fall: lower one here where its file does so."""


def has_any(note: ast.expr | None) -> bool:
    """Whether anything goes, but for values of tables and arrays."""
    if note is None or (isinstance(note, ast.Subscript) and ast.unparse(note.value) in KEYED):
        return False
    if isinstance(note, ast.Name):
        return note.id == "Any"
    return any(has_any(part) for part in ast.iter_child_nodes(note) if isinstance(part, ast.expr))


def public_anys(body: list[ast.stmt]) -> Iterator[tuple[int, str]]:
    """(line, name) of public functions' parameters and results."""
    for node in body:
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            yield from public_anys(node.body)
        elif isinstance(node, ast.FunctionDef) and (not node.name.startswith("_") or node.name == "__init__"):
            given = node.args
            for one in (*given.posonlyargs, *given.args, *given.kwonlyargs, given.vararg, given.kwarg):
                if one is not None and has_any(one.annotation):
                    yield one.lineno, f"{node.name}({one.arg})"
            if has_any(node.returns):
                yield node.lineno, f"{node.name}() ->"


def test_the_rule_sees_what_it_should() -> None:
    text = (
        "def a(b: Any, c: Mapping[str, Any], *d: Any) -> list[Any]: ...\ndef _e(f: Any) -> Any: ...\n"
        "class G:\n    def __init__(self, h: Any | None, i: NDArray[Any]) -> None: ...\n    def j(self) -> int: ...\n"
    )
    names = [name for _, name in public_anys(ast.parse(text).body)]
    assert names == ["a(b)", "a(d)", "a() ->", "__init__(h)"]


def test_no_more_of_it() -> None:
    found, lines = Counter[str](), []
    for folder in LIBRARY:
        for file in sorted((ROOT / folder).rglob("*.py")):
            name = file.relative_to(ROOT).as_posix()
            if name.startswith(FORMULAS):
                continue
            for line, where in public_anys(ast.parse(file.read_text(encoding="utf-8")).body):
                found[name] += 1
                lines.append(f"{name}:{line}: {where}")
    more = [line for line in lines if found[line.partition(":")[0]] > KNOWN.get(line.partition(":")[0], 0)]
    assert not more, "\n".join([*more, "write the type, or a Protocol of what is used of it"])
    assert dict(found) == KNOWN, "fewer than KNOWN says: lower its numbers"
