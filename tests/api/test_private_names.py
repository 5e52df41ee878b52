"""Tests and benchmarks use what the library offers, not what it keeps to itself."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

KNOWN = {
    "tests/api/test_controls.py": 1,
    "tests/api/test_render_views.py": 2,
    "tests/api/test_rest.py": 1,
    "tests/api/test_settings.py": 1,
    "tests/engine/test_gpu_shaders.py": 2,
    "tests/engine/test_graph_random.py": 1,
    "tests/engine/test_graph_run.py": 1,
    "tests/engine/test_graph_views.py": 6,
    "tests/engine/test_validate.py": 1,
    "tests/systems/test_height.py": 1,
    "benchmarks/measure/cloud_sheets.py": 1,
    "benchmarks/measure/demo_cost.py": 1,
}
"""How often a file still does, by its path. Numbers may only fall: lower one here where its file does so less often."""


def is_private(name: str) -> bool:
    return name.startswith("_") and not name.endswith("_")


def private_names(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """(line, name) of private attributes of others and private imports, whether written out or named to monkeypatch."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and is_private(node.attr):
            if not (isinstance(node.value, ast.Name) and node.value.id in ("self", "cls")):
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


def test_no_more_private_names_are_used() -> None:
    found, lines = Counter[str](), []
    for folder in ("tests", "benchmarks"):
        for file in sorted((ROOT / folder).rglob("*.py")):
            name = file.relative_to(ROOT).as_posix()
            for line, private in private_names(ast.parse(file.read_text(encoding="utf-8"))):
                found[name] += 1
                lines.append(f"{name}:{line}: {private}")
    more = [line for line in lines if found[line.partition(":")[0]] > KNOWN.get(line.partition(":")[0], 0)]
    assert not more, "\n".join([*more, "ask for something public, or make it so"])
    assert dict(found) == KNOWN, "fewer than KNOWN says: lower its numbers"
