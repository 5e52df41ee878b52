"""Nobody uses what another keeps to itself: no test and no benchmark of the library, no file of it of another."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

KNOWN = {
    "tests/api/test_render_views.py": 2,
    "tests/api/test_rest.py": 1,
    "tests/api/test_settings.py": 1,
    "tests/engine/test_gpu_shaders.py": 2,
    "tests/engine/test_graph_random.py": 1,
    "tests/engine/test_graph_views.py": 2,
    "tests/engine/test_validate.py": 1,
    "tests/systems/test_height.py": 1,
    "benchmarks/measure/cloud_sheets.py": 1,
    "engine/gpu/gl.py": 1,  # the loader of moderngl, which has no public way to it
    "engine/hosts/native.py": 1,  # the window of moderngl-window, likewise
}
"""How often a file still does, by its path. Numbers may only fall: lower one here where its file does so less often."""


LIBRARY = ("engine", "systems", "planetfall", "components", "games")
OF_NAMED_TUPLES = {"_replace", "_asdict", "_fields"}


def is_private(name: str) -> bool:
    return name.startswith("_") and not name.endswith("_") and name not in OF_NAMED_TUPLES


def private_members(tree: ast.Module) -> set[str]:
    """Names that classes of a file give their members: within it one object may look into another of its kind."""
    found: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            if isinstance(node.value, ast.Name) and node.value.id == "self":
                found.add(node.attr)
        elif isinstance(node, ast.ClassDef):
            found |= {inner.name for inner in node.body if isinstance(inner, ast.FunctionDef)}
    return found


def private_names(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """(line, name) of private attributes of others and private imports, whether written out or named to monkeypatch."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and is_private(node.attr):
            own = isinstance(node.value, ast.Name) and node.value.id in ("self", "cls")
            if not own and ast.unparse(node.value) != "super()":
                yield node.lineno, node.attr
        elif isinstance(node, ast.ImportFrom):
            yield from ((node.lineno, alias.name) for alias in node.names if is_private(alias.name))
        elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith(("getattr", "setattr", "delattr")):
            for given in node.args[:2]:
                if isinstance(given, ast.Constant) and isinstance(given.value, str):
                    last = given.value.rpartition(".")[2]
                    if is_private(last):
                        yield node.lineno, last


def test_the_rule_sees_what_it_should() -> None:
    text = (
        "from a import _b, c\nself._d = x._e.f\nx.__dict__, x._repr_png_()\n"
        "patch.setattr('m._g', 1)\nsetattr(m, '_h', 2)\ngetattr(m, 'i')\n"
    )
    found = sorted(private_names(ast.parse(text)))
    assert found == [(1, "_b"), (2, "_e"), (4, "_g"), (5, "_h")]
    text = "class A:\n    def _a(self): self._b = other._c = super()._d\nkind._replace(_asdict=1)\n"
    assert private_members(ast.parse(text)) == {"_a", "_b"}
    assert sorted(private_names(ast.parse(text))) == [(2, "_c")]


def test_no_more_private_names_are_used() -> None:
    found, lines = Counter[str](), []
    for folder in ("tests", "benchmarks", *LIBRARY):
        for file in sorted((ROOT / folder).rglob("*.py")):
            name, tree = file.relative_to(ROOT).as_posix(), ast.parse(file.read_text(encoding="utf-8"))
            own = private_members(tree) if folder in LIBRARY else set()
            for line, private in private_names(tree):
                if private in own:
                    continue
                found[name] += 1
                lines.append(f"{name}:{line}: {private}")
    more = [line for line in lines if found[line.partition(":")[0]] > KNOWN.get(line.partition(":")[0], 0)]
    assert not more, "\n".join([*more, "ask for something public, or make it so"])
    assert dict(found) == KNOWN, "fewer than KNOWN says: lower its numbers"
