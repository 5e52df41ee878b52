"""run.py: what it installs, when, and what it says when it cannot."""

from __future__ import annotations

import ast
import importlib.util
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def run(tmp_path: Path) -> Iterator[ModuleType]:
    """A fresh copy of run.py that believes it lives in an empty folder."""
    spec = importlib.util.spec_from_file_location("planetfall_run", ROOT / "run.py")
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    (tmp_path / "planetfall").mkdir()
    (tmp_path / "pyproject.toml").write_text("[project]\n")
    (tmp_path / "planetfall" / "_version.py").write_text("")
    module.ROOT = str(tmp_path)  # type: ignore[attr-defined]
    module.VENV = str(tmp_path / ".venv")  # type: ignore[attr-defined]
    module.STAMP = str(tmp_path / ".venv" / "planetfall-stamp.json")  # type: ignore[attr-defined]
    yield module


class Calls:
    """Stands in for subprocess.call: remembers the commands, answers by the first match."""

    def __init__(self, answers: dict[str, int | Callable[[], int]] | None = None) -> None:
        self.commands: list[str] = []
        self.answers = answers or {}

    def __call__(self, command: list[str], **_: object) -> int:
        line = " ".join(command)
        self.commands.append(line)
        for part, answer in self.answers.items():
            if part in line:
                return answer() if callable(answer) else answer
        return 0


def test_only_the_standard_library() -> None:
    tree = ast.parse((ROOT / "run.py").read_text(encoding="utf-8"))
    names = {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    assert names <= set(sys.stdlib_module_names)
    assert not [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]


def test_syntax_is_kept_old() -> None:
    """An old Python must be able to read the file, or it could not start a newer one."""
    ast.parse((ROOT / "run.py").read_text(encoding="utf-8"), feature_version=(3, 7))


def test_macos_is_told_why(
    run: ModuleType, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(run.sys, "platform", "darwin")
    assert run.main([]) == 1
    assert "needs OpenGL 4.3; macOS stops at OpenGL 4.1" in capsys.readouterr().err


def test_installs_once_and_again_after_a_change(
    run: ModuleType, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def make() -> int:
        python = Path(run.venv_python())
        python.parent.mkdir(parents=True, exist_ok=True)
        python.write_text("")
        return 0

    calls = Calls({"-m venv": make})
    monkeypatch.setattr(run.subprocess, "call", calls)
    monkeypatch.setattr(run, "system_libraries", lambda testing: None)
    monkeypatch.setattr(run, "works", lambda python: Path(python).exists())
    assert run.ready_environment(False) == run.venv_python()
    assert [("-m venv" in c, ".[video]" in c) for c in calls.commands] == [(True, False), (False, True)]
    calls.commands.clear()
    run.ready_environment(False)
    assert calls.commands == []
    run.ready_environment(True)
    assert len(calls.commands) == 1 and ".[dev]" in calls.commands[0]
    calls.commands.clear()
    run.ready_environment(False)
    assert calls.commands == []
    (tmp_path / "pyproject.toml").write_text("[project]\nname='x'\n")
    run.ready_environment(False)
    assert len(calls.commands) == 1 and "pip install" in calls.commands[0]


def test_failed_pip_says_what_to_do(run: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run.subprocess, "call", Calls({"pip install": 1}))
    with pytest.raises(run.SetupError, match=r"(?s)offline.*PIP_FIND_LINKS.*pip install"):
        run.install("python", False)
    assert not Path(run.STAMP).exists()


def test_old_python_names_itself_and_the_remedy(run: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run.sys, "version_info", (3, 9, 1))
    monkeypatch.setattr(run.shutil, "which", lambda name: None)
    with pytest.raises(run.SetupError, match=r"needs Python 3\.11 or newer; this is 3\.9 "):
        run.find_python()
    monkeypatch.setattr(run.shutil, "which", lambda name: "/usr/bin/" + name if name == "python3.12" else None)
    monkeypatch.setattr(run, "version_of", lambda command, module="venv": (3, 12))
    assert run.find_python() == ["python3.12"]


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX users")
class TestSystemLibraries:
    @pytest.fixture(autouse=True)
    def _bare_debian(self, run: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
        self.have: set[str] = {"xauth", "glslangValidator", "spirv-val"}
        monkeypatch.setattr(run.sys, "platform", "linux")
        monkeypatch.setattr(run, "present", lambda name: name in self.have)
        monkeypatch.setattr(run.shutil, "which", lambda name: "/usr/bin/" + name)
        monkeypatch.setattr(run.glob, "glob", lambda pattern: ["x"])

    def _installs(self) -> int:
        self.have |= {"libEGL.so.1", "libGL.so.1", "libfontconfig.so.1", "Xvfb"}
        return 0

    def test_as_root(self, run: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
        calls = Calls({" install ": self._installs})
        monkeypatch.setattr(run.subprocess, "call", calls)
        monkeypatch.setattr(run.os, "geteuid", lambda: 0)
        run.system_libraries(True)
        assert len(calls.commands) == 1
        assert calls.commands[0].endswith("libegl1 libfontconfig1 libgl1 xvfb") and "sudo" not in calls.commands[0]
        run.system_libraries(True)
        assert len(calls.commands) == 1

    def test_with_sudo_and_stale_lists(self, run: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
        calls = Calls({" install ": lambda: self._installs() if len(calls.commands) > 2 else 100})
        monkeypatch.setattr(run.subprocess, "call", calls)
        monkeypatch.setattr(run.os, "geteuid", lambda: 1000)
        run.system_libraries(False)
        assert [c.split()[0] for c in calls.commands] == ["/usr/bin/sudo"] * 4
        assert calls.commands[2].endswith("update")

    def test_without_rights_says_what_to_type(self, run: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(run.subprocess, "call", Calls({"-n true": 1}))
        monkeypatch.setattr(run.os, "geteuid", lambda: 1000)
        monkeypatch.setattr(run.sys, "stdin", type("NoTerminal", (), {"isatty": lambda self: False})())
        with pytest.raises(
            run.SetupError, match=r"libEGL\.so\.1.*As root, run: apt-get update && apt-get install .*libegl1"
        ):
            run.system_libraries(False)

    def test_missing_fonts_do_not_stop_the_demo(
        self, run: ModuleType, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
    ) -> None:
        self.have |= {"libEGL.so.1", "libGL.so.1"}
        monkeypatch.setattr(run, "become_root", lambda: None)
        run.system_libraries(False)
        assert "libfontconfig1; going on without" in capsys.readouterr().out

    def test_other_systems_get_the_names(
        self, run: ModuleType, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
    ) -> None:
        monkeypatch.setattr(run.shutil, "which", lambda name: None)
        run.system_libraries(False)
        assert "dnf install mesa-libEGL" in capsys.readouterr().out


def test_all_steps_run_and_are_summed_up(
    run: ModuleType, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    calls = Calls()
    monkeypatch.setattr(run.subprocess, "call", calls)
    monkeypatch.setattr(run, "check_types", lambda python: 1)
    assert run.run_tests("python", ["-k", "world"]) == 1
    assert [command.split()[2] for command in calls.commands] == ["ruff", "pytest"]
    assert calls.commands[1].endswith("-k world")
    shown = capsys.readouterr().out
    lines = shown.split("\n\n")[-1].splitlines()
    assert ["ok" in lines[0], "FAILED" in lines[1], "ok" in lines[2]] == [True, True, True]
    assert sys.platform == "win32" or "processor time" in lines[3]
    assert "run.py test --all" in lines[-1]
    run.run_tests("python", ["--all"])
    assert calls.commands[-1].endswith("--all") and "test --all" not in capsys.readouterr().out


def test_types_are_checked_in_the_installed_shape(
    run: ModuleType, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A checkout has no planetfall/engine; the checker is shown one, and its messages name the real file."""
    for folder in run.FOLDERS:
        (tmp_path / folder).mkdir()
    (tmp_path / "engine" / "world.py").write_text("x = 1\n")

    def checker(command: list[str], cwd: str, **_: object) -> subprocess.CompletedProcess[bytes]:
        copy = Path(cwd) / "planetfall" / "engine" / "world.py"
        assert "basedpyright" in command and copy.read_text() == "x = 1\n"
        assert (Path(cwd) / "planetfall" / "_version.py").exists() and (Path(cwd) / "pyproject.toml").exists()
        return subprocess.CompletedProcess(command, 1, f"{copy}:1:5 - error".encode(), b"noise about the venv path\n")

    monkeypatch.setattr(run.subprocess, "run", checker)
    assert run.check_types("python") == 1
    shown = capsys.readouterr()
    assert shown.out == f"{tmp_path / 'engine' / 'world.py'}:1:5 - error\n" and shown.err == ""


def test_help_needs_no_setup_to_be_read() -> None:
    text = ast.get_docstring(ast.parse((ROOT / "run.py").read_text(encoding="utf-8")))
    assert text and "python3 run.py test" in text


def test_help_installs_nothing(
    run: ModuleType, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    calls = Calls()
    monkeypatch.setattr(run.subprocess, "call", calls)
    monkeypatch.setattr(run, "system_libraries", lambda testing: pytest.fail("looked for libraries to install"))
    assert run.main(["--help"]) == 0
    assert calls.commands == [] and not (tmp_path / ".venv").exists()
    shown = capsys.readouterr().out
    assert "python3 run.py test [options]" in shown and "once it is set up" in shown
    python = Path(run.venv_python())
    python.parent.mkdir(parents=True)
    python.write_text("")
    run.write_stamp(run.wanted_stamp(False))
    assert run.main(["-h"]) == 0
    assert calls.commands == [f"{python} -m planetfall.games.demo_planet --help"]


def test_ci_script_is_valid_bash() -> None:
    script = ROOT / ".ci" / "run"
    if sys.platform != "win32" and script.exists():
        subprocess.run(["bash", "-n", str(script)], check=True)
