"""The documentation says what is so: its diagram, its code, its commands, its files, its tables."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import planetfall as pf
from planetfall.benchmarks.suites import SUITES
from planetfall.cli.main import app, main
from planetfall.systems.flight import load_controls

ROOT = Path(__file__).resolve().parents[2]
DOCS = sorted([ROOT / "README.md", ROOT / "CHANGELOG.md", *(ROOT / "docs").rglob("*.md")])
REFRESH = "planetfall graph earth --view near --into docs/architecture.md"
LARGEST_PICTURE_BYTES = 150_000
SHEETS_BYTES = {"paper.jpg": 300_000, "rivers.jpg": 300_000}
LARGEST_ANIMATION_BYTES = 3_000_000


def blocks(file: Path, language: str) -> list[str]:
    """The fenced blocks of a Markdown file in this language."""
    return re.findall(rf"^```{language}\n(.*?)^```", file.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)


@pytest.mark.gpu
def test_the_diagram_is_that_of_the_program(tmp_path: Path) -> None:
    now = tmp_path / "architecture.md"
    now.write_bytes((ROOT / "docs" / "architecture.md").read_bytes())
    # A program of its own: presets have their clouds there. Waves are seen from there.
    command = [sys.executable, "-m", "planetfall", *shlex.split(REFRESH)[1:-1], str(now), "--size", "320x180"]
    subprocess.run(command, check=True, capture_output=True)
    fresh, written = (blocks(file, "mermaid") for file in (now, ROOT / "docs" / "architecture.md"))
    assert fresh == written, f"the frame graph has changed since docs/architecture.md drew it; refresh it: {REFRESH}"
    assert f"<!-- frame graph: {REFRESH} -->" in now.read_text(encoding="utf-8"), "the block names its own command"


def test_a_document_without_a_place_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "plain.md"
    assert main(["graph", "--into", str(file)]) == 2
    assert "there is no file" in capsys.readouterr().err
    file.write_text("no markers\n", encoding="utf-8")
    assert main(["graph", "--into", str(file)]) == 2
    assert "<!-- frame graph -->" in capsys.readouterr().err
    assert main(["graph", "--into", str(file), "--passes"]) == 2
    assert "leave out" in capsys.readouterr().err
    assert file.read_text(encoding="utf-8") == "no markers\n"


@pytest.mark.gpu
def test_the_lines_of_python_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (code,) = blocks(ROOT / "README.md", "python")
    assert "size=(1280, 720)" in code
    statements = [line for line in code.splitlines() if line.strip()]
    assert len(statements) <= 10, "ten lines, it says"
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    exec(compile(code.replace("(1280, 720)", "(64, 36)"), "README.md", "exec"), names)
    assert (tmp_path / "hills.png").stat().st_size > 0
    assert names["distance_m"].shape == (36, 64)  # type: ignore[attr-defined]
    assert names["heights_m"][0] > 0.0, "the camera should look at land"  # type: ignore[index]


def joined(block: str) -> list[str]:
    """A block's lines, those that end in a backslash with the next."""
    return block.replace("\\\n", " ").splitlines()


def commands() -> list[str]:
    """Every `planetfall ...` line in a shell block or in backticks that gives arguments."""
    found = []
    for file in DOCS:
        text = file.read_text(encoding="utf-8")
        lines = [line.partition("#")[0] for block in blocks(file, "sh") for line in joined(block)]
        lines += re.findall(r"`(planetfall [^`\n]+)`", text)
        found += [line.strip() for line in lines if line.startswith("planetfall ")]
    return sorted(set(found))


@pytest.mark.parametrize("line", commands())
def test_commands_are_understood(line: str, capsys: pytest.CaptureFixture[str]) -> None:
    tokens = shlex.split(line.replace("NAME", "sky.shade"))[1:]
    if tokens[0] in ("bench", "stress"):
        assert main([tokens[0], "--list"] if tokens[0] == "bench" else ["stress", "--help"]) == 0
        listed = capsys.readouterr().out
        for name in [token for token in tokens[1:2] if not token.startswith("-")]:
            assert all(part in listed for part in name.split(".")), f"{line!r}: there is no {name!r}"
        return
    app.parse_args(tokens, exit_on_error=False, print_error=False)
    if "--view" in tokens:
        assert tokens[tokens.index("--view") + 1] in pf.views()


def test_files_named_in_the_docs_exist() -> None:
    suffixes = r"(?:py|md|toml|glsl|comp|frag|vert|jpg)"
    missing = []
    for file in DOCS:
        text = file.read_text(encoding="utf-8")
        named = re.findall(rf"`((?:[\w.-]+/)+[\w.-]*\.{suffixes})`", text)
        named += re.findall(r"`((?:engine|systems|components|assets|tests|games|benchmarks|docs)/[\w./-]*)`", text)
        named = [name for name in named if not name.startswith("generated/")]  # the program makes these texts
        missing += [f"{file.name}: {name}" for name in named if not (ROOT / name).exists()]
        links = re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)", text)
        missing += [f"{file.name}: {link}" for link in links if "://" not in link and not (file.parent / link).exists()]
    assert not missing, "the docs name what isn't there:\n" + "\n".join(sorted(set(missing)))


def test_the_index_has_every_page() -> None:
    index = ROOT / "docs" / "README.md"
    linked = {
        (index.parent / name).resolve() for name in re.findall(r"\]\(([^)#]+)\)", index.read_text(encoding="utf-8"))
    }
    missing = sorted(page.name for page in {*index.parent.rglob("*.md")} - {index} - linked)
    assert not missing, f"docs/README.md doesn't link {missing}"


def test_every_suite_of_benches_is_explained() -> None:
    told = (ROOT / "docs" / "benchmarks-howto.md").read_text(encoding="utf-8")
    assert not [name for name in SUITES if f"`{name}." not in told and f"`{name}`" not in told]


def test_readme_and_changelog_are_short() -> None:
    lines = (ROOT / "README.md").read_text(encoding="utf-8").splitlines()
    assert len(lines) <= 90, "two screens: the rest belongs on pages of docs/"
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8").splitlines()
    assert len(changes) <= 40, "what the version has, at a glance; what programs have to change: docs/upgrading.md"


@pytest.mark.gpu
def test_the_lines_for_a_game_draw() -> None:
    from planetfall.engine.hosts.headless import create_headless

    (code,) = blocks(ROOT / "README.md", "python embedding")
    ctx = create_headless()
    target = ctx.framebuffer([ctx.texture((48, 27), 4)])
    names = {"pf": pf, "size": (48, 27), "your_context": ctx, "your_framebuffer": target}
    exec(compile(code, "README.md", "exec"), names)
    assert max(target.read(components=3)) > 60
    names["renderer"].release()  # type: ignore[attr-defined]
    ctx.release()


def test_every_technique_of_the_sources_has_a_file_a_test_and_a_bench() -> None:
    """Or says why it was left out. Tests and benches are there under the names given."""
    from planetfall.benchmarks.suites import SUITES, benches_of

    text = (ROOT / "docs" / "sources.md").read_text(encoding="utf-8")
    rows = [line for line in text.splitlines() if line.startswith("| ") and line.count("|") == 5]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in rows]
    rows = [row for row in rows if row[0] != "technique, formula, figure"]
    assert len(rows) > 40
    for technique, where, test, bench in rows:
        if where.startswith("left out: "):
            continue
        assert "`" in where, technique
        assert "::" in test, technique
        assert "`" in bench or bench.startswith("left out of the benches: "), technique
    tests = re.findall(r"`(tests/[\w/]+\.py)::(\w+)`", text)
    assert len(tests) > 40
    for file, name in tests:
        assert f"def {name}(" in (ROOT / file).read_text(encoding="utf-8"), f"{file} has no {name}"
    known = {f"{suite}.{bench}" for suite in SUITES for bench in benches_of(suite)}
    named = {name for row in rows for name in re.findall(r"`([a-z]+\.[a-z_ ]+)`", row[3])}
    assert named <= known, named - known


def test_pictures_are_small_and_used() -> None:
    pictures = sorted((ROOT / "docs" / "images").glob("*"))
    used = {
        Path(name).name for file in DOCS for name in re.findall(r"\]\(((?:docs/)?images/[^)]+)\)", file.read_text())
    }
    assert {picture.name for picture in pictures} == used, "docs/make_images.py makes the pictures of the pages"
    limits = {".gif": LARGEST_ANIMATION_BYTES, **SHEETS_BYTES}
    large = [
        p.name for p in pictures
        if p.stat().st_size > limits.get(p.name, limits.get(p.suffix, LARGEST_PICTURE_BYTES))
    ]  # fmt: skip
    assert not large, f"pictures above {LARGEST_PICTURE_BYTES} bytes, or animations above {limits}: {large}"


def test_controls_are_those_of_the_window() -> None:
    section = (ROOT / "docs" / "first-steps.md").read_text(encoding="utf-8").split("## Controls")[1].split("\n## ")[0]
    rows = re.findall(r"^\| ([^|]+) \| ([^|]+) \|$", section, re.MULTILINE)
    assert rows == list(load_controls().help())


def test_qualities_are_those_of_the_presets() -> None:
    section = (ROOT / "docs" / "first-steps.md").read_text(encoding="utf-8").split("## Quality")[1].split("\n## ")[0]
    rows = dict(re.findall(r"^\| `(\w+)` \| ([\d.]+) px \|", section, re.MULTILINE))
    assert list(rows) == [name for name in pf.qualities() if name != "paper"]
    for name, edge_px in rows.items():
        preset = tomllib.loads((pf.ASSETS / "presets" / "quality" / f"{name}.toml").read_text(encoding="utf-8"))
        assert float(edge_px) == preset["terrain"]["edge_px"], name


def test_planets_and_libraries_are_complete() -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert not [name for name in pf.planets() if f"`{name}`" not in readme], "README.md lists the planets"
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    decisions = (ROOT / "docs" / "decisions.md").read_text(encoding="utf-8")
    names = [re.split(r"[<>=\[ ]", line)[0] for line in project["dependencies"]]
    missing = [name for name in names if not re.search(rf"^\| {re.escape(name)} \|", decisions, re.MULTILINE)]
    assert not missing, f"docs/decisions.md has no word on the libraries {missing}"
