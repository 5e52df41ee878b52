"""The house's rules that no linter knows: who may import whom, where a library may be named, what shaders must say.

Every rule reads the sources; a message names file and line, the rule, and what to do.
"""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
LIBRARY = ("engine", "components", "systems", "planetfall")
FOLDERS = (*LIBRARY, "games", "benchmarks")
SHADERS = ROOT / "assets" / "shaders"
SHADER_SUFFIXES = (".glsl", ".vert", ".frag", ".comp", ".geom", ".tesc", ".tese")

TOP_LEVEL = {
    ".ci", ".gitignore", "CHANGELOG.md", "LICENSE", "README.md", "pyproject.toml", "run.py",
    "planetfall", "engine", "components", "systems", "assets", "games", "benchmarks", "tests", "docs",
}  # fmt: skip


# imports


@lru_cache(maxsize=1)
def parsed() -> tuple[dict[Path, ast.Module], list[str]]:
    """The library's syntax trees by file, and the files that have none."""
    trees, broken = {}, []
    for file in sorted(file for folder in FOLDERS for file in (ROOT / folder).rglob("*.py")):
        try:
            trees[file.relative_to(ROOT)] = ast.parse(file.read_text(encoding="utf-8"))
        except SyntaxError as error:
            broken.append(f"{file.relative_to(ROOT)}:{error.lineno}: {error.msg}")
    return trees, broken


def sources() -> dict[Path, ast.Module]:
    return parsed()[0]


def test_every_file_is_python() -> None:
    report(parsed()[1], "fix the syntax; the other rules leave these files out")


def module_of(file: Path) -> str:
    """The name under which a file is imported: engine/gpu/scope.py is planetfall.engine.gpu.scope."""
    parts = list(file.with_suffix("").parts)
    parts = parts if parts[0] == "planetfall" else ["planetfall", *parts]
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imports_of(file: Path, tree: ast.Module) -> Iterator[tuple[int, str, int]]:
    """(line, absolute module name, level): of every import, also those inside functions and TYPE_CHECKING blocks."""
    package = module_of(file) if file.name == "__init__.py" else module_of(file).rpartition(".")[0]
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield node.lineno, alias.name, 0
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                parts = package.split(".")
                stem = ".".join(parts[: len(parts) - node.level + 1])
                base = f"{stem}.{base}".strip(".")
            for alias in node.names:
                yield node.lineno, f"{base}.{alias.name}", node.level


@lru_cache(maxsize=1)
def imports() -> list[tuple[Path, int, str, int]]:
    return [(file, *found) for file, tree in sources().items() for found in imports_of(file, tree)]


def all_imports(*folders: str) -> Iterator[tuple[Path, int, str, int]]:
    return (found for found in imports() if found[0].parts[0] in folders)


def inside(name: str, *packages: str) -> bool:
    return any(name == package or name.startswith(package + ".") for package in packages)


def standard(name: str) -> bool:
    return name.split(".", maxsplit=1)[0] in sys.stdlib_module_names


def report(problems: list[str], remedy: str) -> None:
    assert not problems, "\n".join([*problems, remedy])


def test_components_import_numpy_only() -> None:
    wrong = [
        f"{file}:{line}: imports {name}"
        for file, line, name, _ in all_imports("components")
        if not (standard(name) or inside(name, "numpy", "planetfall.components"))
    ]
    report(wrong, "components are plain data: numpy and the standard library only; move the logic into a system")


def test_engine_knows_no_planet() -> None:
    wrong = [
        f"{file}:{line}: imports {name}"
        for file, line, name, _ in all_imports("engine")
        if inside(name, "planetfall") and not inside(name, "planetfall.engine")
    ]
    report(wrong, "the engine imports neither components nor systems nor the public API: pass in what it needs")


def test_systems_never_import_each_other() -> None:
    wrong = []
    for file, line, name, _ in all_imports("systems"):
        own = ".".join(["planetfall", *file.parts[:2]]).removesuffix(".py")
        if inside(name, "planetfall") and not inside(name, "planetfall.engine", "planetfall.components", own):
            wrong.append(f"{file}:{line}: imports {name}")
    report(wrong, "systems meet in components, world resources, named graph resources and shader contracts only")


def test_nobody_imports_games_or_benchmarks() -> None:
    wrong = [
        f"{file}:{line}: imports {name}"
        for file, line, name, _ in all_imports(*LIBRARY)
        if inside(name, "planetfall.games", "planetfall.benchmarks", "tests")
        and not (file == Path("planetfall/cli/main.py") and inside(name, "planetfall.benchmarks"))
    ]
    report(wrong, "only the command line may start benchmarks, and nothing in the library may know a game")


def test_games_use_the_public_api() -> None:
    wrong = []
    for file, line, name, level in all_imports("games"):
        own = ".".join(["planetfall", *file.parts[:2]])
        public = ("planetfall", "planetfall.extend")
        if inside(name, "planetfall") and name not in public and not (level and inside(name, own)):
            wrong.append(f"{file}:{line}: imports {name}")
    report(wrong, "a game imports planetfall and planetfall.extend and nothing deeper, as other people's games do")


def test_games_use_public_names_only() -> None:
    import planetfall as pf

    wrong = []
    for file, tree in sources().items():
        if file.parts[0] != "games":
            continue
        for node in ast.walk(tree):
            named = isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "pf"
            if named and node.attr not in pf.__all__:
                wrong.append(f"{file}:{node.lineno}: uses pf.{node.attr}")
    report(wrong, "games use what planetfall.__all__ lists; add the name there or do without")


def test_imports_inside_the_library_are_relative() -> None:
    wrong = [
        f"{file}:{line}: imports {name}"
        for file, line, name, level in all_imports(*LIBRARY)
        if level == 0 and inside(name, "planetfall", *FOLDERS[:3], "games", "benchmarks")
    ]
    report(wrong, "write a relative import: it reads the same in a checkout and in an installed wheel")


def test_relative_imports_stay_in_the_package() -> None:
    wrong = [
        f"{file}:{line}: climbs out of planetfall ({name})"
        for file, line, name, level in all_imports(*FOLDERS)
        if level and not inside(name, "planetfall")
    ]
    report(wrong, "too many dots: from systems/x/y.py, planetfall is three dots up")


@pytest.mark.parametrize(
    ("library", "places"),
    [
        ("imgui_bundle", ("systems/tweak/", "systems/debug/", "engine/gpu/imgui_backend")),
        ("pyglet", ("engine/hosts/", "games/")),
        ("glfw", ("engine/hosts/", "games/")),
        ("moderngl_window", ("engine/hosts/", "games/")),
        ("esper", ("engine/world.py",)),
        ("cyclopts", ("planetfall/cli/", "benchmarks/cli")),
        ("rich", ("planetfall/cli/", "benchmarks/", "games/")),
        ("imageio_ffmpeg", ("systems/capture/",)),
        ("OpenGL", ()),
    ],
)
def test_libraries_are_named_in_their_place_only(library: str, places: tuple[str, ...]) -> None:
    wrong = [
        f"{file}:{line}: imports {name}"
        for file, line, name, _ in all_imports(*FOLDERS)
        if inside(name, library) and not file.as_posix().startswith(places or "-")
    ]
    report(wrong, f"{library} belongs into {' or '.join(places) or 'nothing here'}")


def test_private_moderngl_is_in_one_module() -> None:
    wrong = [
        f"{file}:{node.lineno}: touches mglo._context"
        for file, tree in sources().items()
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute) and node.attr == "_context" and file != Path("engine/gpu/gl.py")
        if isinstance(node.value, ast.Attribute) and node.value.attr == "mglo"
    ]
    report(wrong, "moderngl's private side may change: only engine/gpu/gl.py touches it")


def test_the_library_does_not_print() -> None:
    wrong = [
        f"{file}:{node.lineno}: calls print"
        for file, tree in sources().items()
        if file.parts[0] in LIBRARY
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "print"
    ]
    report(wrong, "use logging.getLogger(__name__); the command line uses rich")


# files


@lru_cache(maxsize=1)
def tracked() -> list[Path]:
    """The files of the repository, by git; none in an unpacked archive."""
    try:
        answer = subprocess.run(
            ["git", "ls-files", "-z"], cwd=ROOT, check=True, capture_output=True, timeout=30
        ).stdout.decode()
    except (OSError, subprocess.SubprocessError):
        return []
    return [Path(name) for name in answer.split("\0") if name and (ROOT / name).is_file()]


def test_top_level_is_as_agreed() -> None:
    unknown = sorted({file.parts[0] for file in tracked()} - TOP_LEVEL)
    report([f"{name}: not part of the agreed layout" for name in unknown], "put it into one of the folders there are")


def test_no_names_of_a_private_workplace() -> None:
    # Put together here, so that this file does not name them itself.
    names = "|".join(
        ["/wo" + "rk/", r"\bsha" + "red/", *(rf"\b{n}\.md" for n in ("DESI" + "GN", "STA" + "CK", "STY" + "LE"))]
    )
    pattern = re.compile(names)
    wrong = []
    for file in tracked():
        if file.suffix.lower() in (".png", ".jpg", ".jpeg", ".npz", ".mp4"):
            continue
        for number, line in enumerate((ROOT / file).read_text(encoding="utf-8", errors="replace").splitlines(), 1):
            if pattern.search(line):
                wrong.append(f"{file}:{number}: {line.strip()[:80]}")
    report(wrong, "nobody else has these paths: say the thing itself, or cite the source by name")


# shaders


def without_comments(text: str) -> str:
    """GLSL with comments blanked out, line numbers kept."""
    return re.sub(r"//[^\n]*|/\*.*?\*/", lambda found: "\n" * found[0].count("\n"), text, flags=re.S)


@lru_cache(maxsize=1)
def shaders() -> dict[str, str]:
    """Shader sources without comments, by their path as #include writes it."""
    return {
        file.relative_to(SHADERS).as_posix(): without_comments(file.read_text(encoding="utf-8"))
        for file in sorted(SHADERS.rglob("*"))
        if file.is_file()
    }


DECLARATION = re.compile(
    r"^[ \t]*(?P<layout>layout\s*\([^)]*\)\s*)?"
    r"(?:(?:readonly|writeonly|coherent|restrict|volatile|highp|mediump)\s+)*"
    r"(?:(?P<opaque>uniform\s+(?:(?:readonly|writeonly|coherent|restrict|volatile|highp|mediump)\s+)*[iu]?"
    r"(?:sampler|image)\w+)|(?P<block>(?:uniform|(?:(?:readonly|writeonly|coherent|restrict)\s+)*buffer)\s+\w+\s*\{))",
    re.M,
)


def unbound(text: str) -> list[tuple[int, str]]:
    """(line, declaration) of samplers, images, uniform and storage blocks that name no binding."""
    return [
        (text.count("\n", 0, found.start()) + 1, " ".join(found[0].split()).rstrip("{"))
        for found in DECLARATION.finditer(text)
        if not re.search(r"\bbinding\s*=", found["layout"] or "")
    ]


def test_the_binding_rule_sees_what_it_should() -> None:
    text = (
        "layout(binding = 0) uniform sampler2D a;\nuniform sampler3D b;\nuniform float c;\n"
        "layout(std140, binding = 1) uniform D {\nlayout(std430) readonly buffer E {\nfloat f(sampler2D s);\n"
        "layout(rgba16f) writeonly uniform image2D g;\nlayout(rgba16f, binding = 2) uniform writeonly image2D h;\n"
        "uniform usampler2D i;\nlayout(std430, binding = FOO) restrict buffer J {\n"
    )
    assert [line for line, _ in unbound(text)] == [2, 5, 7, 9]


def test_every_shader_binding_is_explicit() -> None:
    wrong = [
        f"assets/shaders/{name}:{line}: {what}" for name, text in shaders().items() for line, what in unbound(text)
    ]
    report(wrong, "write layout(binding = N): two kinds of sampler on the default unit 0 abort some drivers")


INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]+"([^"]+)"', re.M)
NOT_FILES = ("generated/", "virtual/")


def included(name: str) -> list[str]:
    """The files that a shader includes; a contract counts as its default."""
    names = [re.sub(r"^contract/", "common/", found) for found in INCLUDE.findall(shaders()[name])]
    return [found for found in names if not found.startswith(NOT_FILES)]


def test_every_include_exists() -> None:
    wrong = [
        f"assets/shaders/{name}: includes {found!r}"
        for name in shaders()
        for found in included(name)
        if found not in shaders()
    ]
    report(wrong, "includes are written from assets/shaders/; a contract's default lies in common/")


def test_every_shader_file_is_reachable() -> None:
    text = "\n".join((ROOT / file).read_text(encoding="utf-8") for file in sources())
    suffixes = "|".join(suffix[1:] for suffix in SHADER_SUFFIXES)
    named = {re.sub(r"^contract/", "common/", name) for name in re.findall(rf"[\w/]+\.(?:{suffixes})\b", text)}
    # Defaults of contracts are found by the contract's name alone.
    reached = {name for name in shaders() if name in named}
    waiting = list(reached)
    while waiting:
        for found in included(waiting.pop()):
            if found in shaders() and found not in reached:
                reached.add(found)
                waiting.append(found)
    lost = [f"assets/shaders/{name}: nothing loads or includes it" for name in shaders() if name not in reached]
    report(lost, "delete it, or load it")


def test_shader_files_have_shader_names() -> None:
    wrong = [f"assets/shaders/{name}" for name in shaders() if not name.endswith(SHADER_SUFFIXES)]
    report(wrong, f"files under assets/shaders end in one of {', '.join(SHADER_SUFFIXES)}")


def test_shaders_lie_in_assets_only() -> None:
    wrong = [
        str(f)
        for f in tracked()
        if f.suffix in SHADER_SUFFIXES
        and f.parts[:2] != ("assets", "shaders")
        and not (f.parts[0] == "games" and f.parts[2] == "shaders")
    ]
    report(wrong, "shaders belong into assets/shaders, those of a game into its own folder shaders")
