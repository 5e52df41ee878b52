"""The registry of binding points: shaders and Python take their numbers from it, and the page shows it."""

from __future__ import annotations

import importlib.util
import re
from itertools import combinations
from pathlib import Path

import pytest

from planetfall.engine.blocks import bindings
from planetfall.engine.gpu.preprocess import ShaderSources

ROOT = Path(__file__).resolve().parents[2]
SHADERS = ROOT / "assets" / "shaders"
STAGES = (".comp", ".vert", ".frag")
DECLARED = re.compile(r"layout\(([^)]*)\)\s*([^;{]*?)\b(\w+)\s*(?:\[[^]]*\]\s*)*[{;]")
LITERAL = re.compile(r"\.use\((\d+)\)|bind_to_(uniform_block|storage_buffer|image)\((\d+)|_(?:UNIT|BINDING) = \d+\b")


def declared(text: str) -> list[tuple[str, str, str]]:
    """(kind, what stands for the number, name) of each binding in a shader."""
    found = []
    for layout, words, name in DECLARED.findall(text):
        number = re.search(r"binding\s*=\s*(\w+)", layout)
        if number:
            kind = "image" if "image" in words else "storage buffer" if "buffer" in words.split() else "texture unit"
            kind = "uniform block" if "std140" in layout and "uniform" in words else kind
            found.append((kind, number[1], name))
    return found


def wrong_literals(name: str, text: str) -> list[str]:
    """Numbers of a shader file that belong into the registry: files that others include have none, and a stage only
    those that are its pass's own."""
    return [
        f"{name}: {variable} has {kind} {number}"
        for kind, number, variable in declared(text)
        if number.isdigit()
        and (kind == "uniform block" or not name.endswith(STAGES) or int(number) not in bindings.OWN[kind])
    ]


def two_meanings(text: str) -> list[str]:
    """Points of an expanded program that two variables share. Names of the registry count as their numbers."""
    held: dict[tuple[str, int], dict[str, dict[int, int]]] = {}
    for branches, part in _branches(text):
        for kind, number, name in declared(part):
            point = bindings.points().get(number)
            if point is not None and point.kind != kind:
                return [f"{name} is no {point.kind}: {number}"]
            if point is not None or number.isdigit():
                there = held.setdefault((kind, int(number) if point is None else int(point)), {})
                there[name] = {} if name in there else branches
    return [
        f"{kind} {number}: {a}, {b}"
        for (kind, number), names in held.items()
        for a, b in combinations(sorted(names), 2)
        if all(names[a][k] == names[b][k] for k in names[a].keys() & names[b].keys())
    ]


def _branches(text: str) -> list[tuple[dict[int, int], str]]:
    """The text between directives, and which branch of which #if it stands in: {number of the #if: branch}."""
    stack: list[tuple[int, int]] = []
    found: list[tuple[dict[int, int], str]] = []
    for number, piece in enumerate(re.split(r"^[ \t]*#[ \t]*(?=if|el|endif)", text, flags=re.MULTILINE)):
        if number:
            if piece.startswith("if"):
                stack.append((number, 0))
            elif piece.startswith("el"):
                stack[-1] = (stack[-1][0], stack[-1][1] + 1)
            else:
                stack.pop()
        found.append((dict(stack), piece))
    return found


def test_shaders_take_shared_numbers_from_the_registry():
    folders = (SHADERS, ROOT / "games")
    files = [f for folder in folders for f in folder.rglob("*") if f.suffix in (*STAGES, ".glsl")]
    assert len(files) > 200
    assert not [w for f in files for w in wrong_literals(f.name, f.read_text(encoding="utf-8"))]
    assert wrong_literals("a.glsl", "layout(binding = 2) uniform sampler2D u_a;") == ["a.glsl: u_a has texture unit 2"]
    assert wrong_literals("a.comp", "layout(std140, binding = 15) uniform A { vec4 a[2]; } b;")
    assert wrong_literals("a.frag", "layout(binding = 8) uniform sampler2D u_a;")
    assert not wrong_literals("a.comp", "layout(r8, binding = 1) uniform image2D u_a;\nlayout(binding = A) buffer B {")


def shared_literals(files: dict[str, str]) -> list[str]:
    """Blocks and buffers that several shaders declare by the same name and the same number: their point needs one."""
    held: dict[tuple[str, str, str], list[str]] = {}
    for name, text in files.items():
        for kind, number, variable in declared(text):
            if number.isdigit() and kind in ("uniform block", "storage buffer"):
                held.setdefault((kind, number, variable), []).append(name)
    shared = {what: sorted(of) for what, of in held.items() if len(of) > 1}
    return [f"{kind} {number}: {name} in {', '.join(of)}" for (kind, number, name), of in shared.items()]


def test_what_several_shaders_share_has_a_name():
    files = {f.relative_to(SHADERS).as_posix(): f.read_text(encoding="utf-8") for f in SHADERS.rglob("*.*")}
    assert not shared_literals(files)
    block = "layout(std430, binding = 3) buffer A { uint a[]; };"
    assert shared_literals({"b.comp": block, "c.comp": block}) == ["storage buffer 3: A in b.comp, c.comp"]


@pytest.mark.parametrize("folder", sorted(f.name for f in SHADERS.iterdir()))
def test_no_number_means_two_things_in_one_program(folder):
    sources = ShaderSources([SHADERS])
    for file in (SHADERS / folder).rglob("*"):
        if file.suffix in STAGES:
            name = file.relative_to(SHADERS).as_posix()
            assert not two_meanings(_expanded(sources, name, set())), name


def _expanded(sources: ShaderSources, name: str, done: set[str]) -> str:
    """A file with all that it includes, each contract with all its answers; not what is generated."""
    done.add(name)
    text = sources.read(name) or ""
    for target in re.findall(r'^#include "([^"]+)"', text, re.MULTILINE):
        names = [target, (Path(name).parent / target).as_posix()]
        if target.startswith("contract/"):
            names = [f.relative_to(SHADERS).as_posix() for f in SHADERS.glob(f"*/{Path(target).name}")]
        for found in names:
            if found not in done and sources.read(found):
                text += "\n" + _expanded(sources, found, done)
    return text


def test_two_meanings_are_found():
    one = "layout(binding = AIR_DEPTH_UNIT) uniform sampler2D u_a;\n"
    assert not two_meanings(one + "layout(binding = 8) buffer B {\n" + one)
    assert two_meanings(one + "layout(binding = 8) uniform sampler2D u_b;\n") == ["texture unit 8: u_a, u_b"]
    other = "layout(binding = 8) uniform sampler3D u_b;\n#endif\n"
    assert not two_meanings("#ifdef A\n" + one + "#else\n" + other) and two_meanings(one + "#ifdef A\n" + other)
    assert two_meanings("layout(std430, binding = AIR_DEPTH_UNIT) readonly buffer B { uint b[]; };")


def test_python_takes_shared_numbers_from_the_registry():
    wrong = []
    for folder in ("engine", "systems", "planetfall", "games", "components", "benchmarks"):
        for file in (ROOT / folder).rglob("*.py"):
            if file.name == "bindings.py" or "guard" in file.name:
                continue
            for unit, kind, number in _literals(file.read_text(encoding="utf-8")):
                own = bindings.OWN[kind.replace("_", " ") if kind else "texture unit"]
                if not (unit or number) or kind == "uniform_block" or int(unit or number) not in own:
                    wrong.append(f"{file.relative_to(ROOT)}: {kind or 'texture unit'} {unit or number}")
    assert not wrong
    assert _literals("a.use(9); b.bind_to_uniform_block(3)\nC_UNIT = 4\nGL_BINDING = 0x90D3") == [
        ("9", "", ""), ("", "uniform_block", "3"), ("", "", ""),
    ]  # fmt: skip


def test_python_binds_by_every_name_of_the_registry():
    files = [f for folder in ("engine", "systems") for f in (ROOT / folder).rglob("*.py") if f.name != "bindings.py"]
    words = set(re.findall(r"\w+", "\n".join(f.read_text(encoding="utf-8") for f in files)))
    assert not bindings.points().keys() - words


def _literals(text: str) -> list[tuple[str, str, str]]:
    return LITERAL.findall(text)


def test_the_numbers_are_sound():
    named = bindings.points()
    assert {p.kind for p in named.values()} == set(bindings.OWN) == set(bindings.POINTS)
    for name, point in named.items():
        assert name.endswith("_" + point.kind.split()[-1].upper()) and 0 <= point < bindings.POINTS[point.kind]
        assert f"#define {name} {int(point)}\n" in bindings.glsl()
    blocks = [p for p in named.values() if p.kind == "uniform block"]
    assert not set(bindings.OWN["uniform block"]) & set(blocks)


def test_the_page_is_current():
    spec = importlib.util.spec_from_file_location("make_api", ROOT / "docs" / "make_api.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    page = (ROOT / "docs" / "bindings.md").read_text(encoding="utf-8")
    assert page == module.bindings_text(), "docs/bindings.md is not the registry: python docs/make_api.py"
