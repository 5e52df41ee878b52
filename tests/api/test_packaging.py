"""The wheel and the source archive hold all that is needed, under one import name."""

from __future__ import annotations

import json
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
INSIDE = ("engine", "components", "systems", "assets", "games", "benchmarks")

pytest.importorskip("hatchling", reason="comes with the extra 'dev'")


def build(kind: str, folder: Path) -> Path:
    """Builds in a process of its own: hatchling changes the working directory."""
    code = (
        "import sys\n"
        "from hatchling.builders.sdist import SdistBuilder\n"
        "from hatchling.builders.wheel import WheelBuilder\n"
        "builder = {'wheel': WheelBuilder, 'sdist': SdistBuilder}[sys.argv[1]]('.')\n"
        "print(list(builder.build(directory=sys.argv[2], versions=['standard']))[0])\n"
    )
    answer = subprocess.run(
        [sys.executable, "-c", code, kind, str(folder)], cwd=ROOT, check=True, capture_output=True, text=True
    )
    return Path(answer.stdout.strip().splitlines()[-1])


def expected_files() -> set[str]:
    """All sources, shaders and presets of the checkout, as the wheel names them."""
    found = {f"planetfall/{file.name}" for file in (ROOT / "planetfall").glob("*.py")} | {"planetfall/py.typed"}
    for folder in INSIDE:
        for file in (ROOT / folder).rglob("*"):
            if file.is_file() and "__pycache__" not in file.parts:
                found.add(f"planetfall/{file.relative_to(ROOT).as_posix()}")
    return found


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build("wheel", tmp_path_factory.mktemp("wheel"))


def test_wheel_holds_everything_under_one_name(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
    assert wheel.name.endswith("-py3-none-any.whl")
    assert {name.split("/")[0] for name in names if ".dist-info" not in name} == {"planetfall"}
    assert not expected_files() - names
    assert any(name.startswith("planetfall/assets/shaders/") for name in names)
    assert any(name.startswith("planetfall/assets/presets/planets/") for name in names)
    assert not [name for name in names if name.endswith(".pyc") or "/tests/" in name]
    assert any(name.endswith("licenses/LICENSE") for name in names)


def test_wheel_has_the_console_script(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        entry = next(name for name in archive.namelist() if name.endswith("entry_points.txt"))
        assert "planetfall = planetfall.cli.main:main" in archive.read(entry).decode()


def test_wheel_works_without_the_checkout(wheel: Path, tmp_path: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path)
    code = (
        "import json, planetfall as pf, planetfall.engine.world as world\n"
        "shaders = len(list(pf.ASSETS.rglob('*.frag')))\n"
        "print(json.dumps([str(pf.ASSETS), world.__file__, pf.planets(), pf.paths(), shaders]))"
    )
    answer = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, env={"PYTHONPATH": str(tmp_path), "PATH": ""}, check=True,
        capture_output=True, text=True,
    )  # fmt: skip
    assets, world, planets, paths, shaders = json.loads(answer.stdout)
    assert Path(assets) == tmp_path / "planetfall" / "assets"
    assert Path(world).is_relative_to(tmp_path)
    assert "earth" in planets and "descent" in paths and shaders > 0


def test_sdist_holds_everything(tmp_path: Path) -> None:
    archive = build("sdist", tmp_path)
    with tarfile.open(archive) as file:
        names = {name.partition("/")[2] for name in file.getnames()}
    wanted = {name if name.count("/") == 1 else name.removeprefix("planetfall/") for name in expected_files()}
    assert not wanted - names
    assert {"run.py", "README.md", "CHANGELOG.md", "LICENSE", "pyproject.toml", "tests/api/test_packaging.py"} <= names
    assert not [name for name in names if name.startswith((".venv", "build/", ".git/"))]
