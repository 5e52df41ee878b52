"""Every block of the tutorials runs, in order, at a small size; pages that programs write are current."""

from __future__ import annotations

import importlib.util
import re
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from PIL import Image

import planetfall as pf
from planetfall import extend
from planetfall.systems.terrain.material_list import listed
from planetfall.systems.terrain.materials import MATERIALS

ROOT = Path(__file__).resolve().parents[2]
TUTORIALS = sorted((ROOT / "docs" / "tutorials").glob("*.md"))


def python_of(file: Path) -> str:
    """All its Python, as one program whose lines are those of the file."""
    lines, inside = [], False
    for line in file.read_text(encoding="utf-8").splitlines():
        fence = line.startswith("```")
        inside = (line.startswith("```python") or inside) and not (fence and inside)
        lines.append(line if inside and not fence else "")
    return "\n".join(lines)


def small(code: str) -> str:
    """The same at a few pixels and the lowest quality: what it teaches doesn't depend on them."""
    code = re.sub(r"size=\(\d+, \d+\)", "size=(48, 27)", code)
    return code.replace('quality="medium"', 'quality="low"')


def test_there_are_the_tutorials_that_the_index_lists() -> None:
    index = (ROOT / "docs" / "README.md").read_text(encoding="utf-8")
    assert len(TUTORIALS) == 8
    assert not [file.name for file in TUTORIALS if f"tutorials/{file.name}" not in index]


@pytest.mark.gpu
@pytest.mark.parametrize("file", TUTORIALS, ids=lambda file: file.stem)
def test_every_block_runs(file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    code = small(python_of(file))
    assert code.strip()
    before = set(extend.registered_systems())
    module = ModuleType(f"tutorial_{file.stem.replace('-', '_')}")
    monkeypatch.setitem(sys.modules, module.__name__, module)  # dataclasses look their annotations up in it
    exec(compile(code, str(file), "exec", dont_inherit=True), vars(module))
    assert set(extend.registered_systems()) == before and listed() == MATERIALS
    for picture in re.findall(r'save\("(\w+\.png)"\)', code):
        with Image.open(tmp_path / picture) as image:
            assert np.ptp(np.asarray(image).astype(int)) > 100, f"{picture}: nothing to see"


@pytest.mark.gpu
def test_the_first_picture_in_a_host_draws(monkeypatch: pytest.MonkeyPatch) -> None:
    """docs/embedding.md's ten lines against a stand-in for the window: a moderngl context and a framebuffer."""
    from types import SimpleNamespace

    from planetfall.engine.hosts.headless import create_headless

    text = (ROOT / "docs" / "embedding.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"^```python first-picture\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
    ctx = create_headless()
    target = ctx.framebuffer([ctx.texture((48, 27), 4)])
    drawn = []

    class Window:
        def __init__(self, *_: object, **__: object) -> None:
            self.get_framebuffer_size = lambda: (48, 27)

        def event(self, function: object) -> None:
            drawn.append(function)

        def clear(self) -> None:
            target.clear()

    fake = SimpleNamespace(
        window=SimpleNamespace(Window=Window),
        gl=SimpleNamespace(Config=lambda **_: None),
        app=SimpleNamespace(run=lambda: [draw() for draw in drawn]),
    )
    body = code.replace("import moderngl, pyglet", "").replace("import moderngl\nimport pyglet", "")
    body = body.replace("(960, 540), ctx=", '(48, 27), quality="low", ctx=').replace("renderer.ctx.screen", "target")
    names = {"pyglet": fake, "moderngl": SimpleNamespace(create_context=lambda: ctx), "target": target}
    exec(compile(body, "docs/embedding.md", "exec"), names)
    assert max(target.read(components=3)) > 60
    names["renderer"].release()  # type: ignore[attr-defined]
    ctx.release()


def made_by(program: str) -> str:
    """The page that a program of docs/ would write."""
    spec = importlib.util.spec_from_file_location(program, ROOT / "docs" / f"{program}.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return str(module.text())


def test_the_reference_is_current() -> None:
    page = (ROOT / "docs" / "api.md").read_text(encoding="utf-8")
    assert page == made_by("make_api"), "docs/api.md is not what the docstrings say: python docs/make_api.py"
    missing = [n for n in pf.__all__ if not n.startswith("__") and n != "ASSETS" and f"### `pf.{n}`" not in page]
    assert not missing


def test_the_table_of_materials_is_current() -> None:
    page = (ROOT / "docs" / "materials.md").read_text(encoding="utf-8")
    assert page == made_by("make_materials"), "docs/materials.md is not what the list says: docs/make_materials.py"
