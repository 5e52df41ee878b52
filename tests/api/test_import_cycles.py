"""No module imports itself by way of others, counting imports inside functions and for type checking."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from pathlib import Path

from test_arrows import FOLDERS, imports_of, module_of, report, sources


def graph_of(trees: Mapping[Path, ast.Module]) -> dict[str, set[str]]:
    """Module -> the modules that it names in an import, anywhere in its file."""
    files = {module_of(file): (file, tree) for file, tree in trees.items()}
    passed_on = {module_of(file): handed_on(file, tree) for file, tree in trees.items() if file.name == "__init__.py"}

    def target(module: str, name: str) -> str:
        """The longest part of "package.module.thing" that is a module."""
        if name in files or not name:
            return name
        package, _, thing = name.rpartition(".")
        # A module's own packages are loaded before it in any case: what counts is where they have the thing from.
        if package in passed_on and module.startswith(f"{package}."):
            source = passed_on[package].get(thing, "")
            return "" if source == package else target(module, source)
        return target(module, package)

    return {
        module: {target(module, name) for _, name, _ in imports_of(file, tree)} - {"", module}
        for module, (file, tree) in files.items()
    }


def handed_on(file: Path, tree: ast.Module) -> dict[str, str]:
    """Of a package's __init__: what it imports by name -> its full name there."""
    return {name.rpartition(".")[2]: name for _, name, _ in imports_of(file, tree)}


def circles(graph: Mapping[str, set[str]]) -> set[frozenset[str]]:
    """Strongly connected components of more than one module (Tarjan)."""
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found: set[frozenset[str]] = set()

    def visit(module: str) -> None:
        index[module] = low[module] = len(index)
        stack.append(module)
        for other in sorted(graph[module]):
            if other not in index:
                visit(other)
                low[module] = min(low[module], low[other])
            elif other in stack:
                low[module] = min(low[module], index[other])
        if low[module] == index[module]:
            members = frozenset(stack[stack.index(module) :])
            del stack[stack.index(module) :]
            if len(members) > 1:
                found.add(members)

    for module in graph:
        if module not in index:
            visit(module)
    return found


def test_no_module_imports_itself_by_way_of_others() -> None:
    graph = graph_of({file: tree for file, tree in sources().items() if file.parts[0] in FOLDERS})
    wrong = []
    for members in circles(graph):
        arrows = [f"{one} -> {other}" for one in members for other in graph[one] & members]
        wrong.append(f"circle of {', '.join(sorted(members))}\n    " + "\n    ".join(sorted(arrows)))
    report(sorted(wrong), "put what both need into a module of its own, or move the function to where it belongs")


def test_the_rule_sees_planted_circles() -> None:
    texts = {
        "engine/__init__.py": "from .a import f\nfrom .e import E\nHERE = 1",
        "engine/a.py": "def f():\n    from .b import g\n    return g",
        "engine/e.py": "from . import HERE, E2\nfrom .h import H",
        "engine/h.py": "from . import E",
        "engine/b.py": "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from ..systems import c",
        "systems/c.py": "from ..engine import a as other\nimport planetfall.systems.d",
        "systems/d.py": "import ast\nfrom . import d",
    }
    graph = graph_of({Path(file): ast.parse(text) for file, text in texts.items()})
    prefix = "planetfall."
    assert graph[f"{prefix}systems.d"] == set()
    assert graph[f"{prefix}engine"] == {f"{prefix}engine.a", f"{prefix}engine.e"}
    assert circles(graph) == {
        frozenset({f"{prefix}engine.a", f"{prefix}engine.b", f"{prefix}systems.c"}),
        frozenset({f"{prefix}engine.e", f"{prefix}engine.h"}),  # by way of the package that hands E on
    }
