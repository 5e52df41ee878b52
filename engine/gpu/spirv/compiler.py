"""The reference compiler (glslang, with spirv-val) on one stage's expanded text."""

from __future__ import annotations

import hashlib
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

from ..errors import GpuError, ShaderError, ShaderMessage
from ..preprocess import Expanded
from .module import Module

__all__ = ["ReferenceCompiler"]

_SUFFIX = {
    "vertex": "vert", "fragment": "frag", "geometry": "geom", "compute": "comp", "tess_control": "tesc",
    "tess_evaluation": "tese",
}  # fmt: skip
_PROGRAMS = {"glslangValidator": "glslang-tools", "spirv-val": "spirv-tools"}
_PLACE = re.compile(r"(?:ERROR|WARNING): \S*?:(?P<line>\d+): (?P<text>.*)")
_STRICT_TEXT = re.compile(r"cannot convert|wrong operand types|no matching overloaded function|reserved word|can't use")
_STRICT_HEAD = "#version 320 es\n#define PF_STRICT 1\n" + "".join(
    f"precision highp {kind};\n"
    for kind in (
        "float", "int", "sampler2D", "sampler3D", "sampler2DArray", "isampler2D", "usampler2D", "isampler3D",
        "usampler3D", "usampler2DArray", "isampler2DArray", "samplerCube", "sampler2DShadow", "image2D", "image3D",
        "image2DArray", "uimage2D", "iimage2D", "uimage3D", "iimage3D", "uimage2DArray",
    )
)  # fmt: skip
_TIMEOUT_S = 120.0


class ReferenceCompiler:
    """Compiles stages to OpenGL SPIR-V and validates it.

    folder: where SPIR-V is kept by the hash of its text, so that only text that is new is compiled; None: nowhere.
    GpuError where the two programs are not installed.
    """

    def __init__(self, folder: Path | None = None) -> None:
        missing = [name for name in _PROGRAMS if shutil.which(name) is None]
        if missing:
            packages = " ".join(_PROGRAMS[name] for name in missing)
            raise GpuError(
                f"checking shaders needs {' and '.join(missing)} on the PATH, found none; install them "
                f"(Debian: apt-get install {packages}; elsewhere: the Vulkan SDK) or leave the check out"
            )
        self._folder = folder

    def compile(self, stage: str, expanded: Expanded) -> Module:
        """The stage's SPIR-V. ShaderError, with files and lines, where either program refuses it."""
        kept = self._kept(stage, expanded.text)
        if kept is not None and kept.exists():
            return Module(kept.read_bytes())
        with tempfile.TemporaryDirectory(prefix="planetfall-spirv-") as name:
            made = Path(name) / "stage.spv"
            source = Path(name) / f"stage.{_SUFFIX[stage]}"
            source.write_text(expanded.text, encoding="utf-8")
            self._run(expanded, "glslangValidator", "-G", "--aml", "--amb", "-o", str(made), str(source))
            self._run(expanded, "spirv-val", "--target-env", "opengl4.5", str(made))
            words = made.read_bytes()
        if kept is not None:
            kept.parent.mkdir(parents=True, exist_ok=True)
            beside = kept.with_suffix(".new")
            beside.write_bytes(words)
            beside.replace(kept)
        return Module(words)

    def strict(self, stage: str, expanded: Expanded) -> list[ShaderMessage]:
        """What a front end without implicit conversions refuses: the text is read as OpenGL ES 3.2 for that, and only
        messages about types and reserved words count. Text with doubles, which ES lacks, gives nothing."""
        if re.search(r"\bd(ouble|vec[234]|mat[234])\b", expanded.text):
            return []
        first, _, rest = expanded.text.partition("\n")
        assert first.startswith("#version")
        shift = _STRICT_HEAD.count("\n") - 1
        with tempfile.TemporaryDirectory(prefix="planetfall-spirv-") as name:
            source = Path(name) / f"stage.{_SUFFIX[stage]}"
            source.write_text(_STRICT_HEAD + rest, encoding="utf-8")
            # Only read, not linked: one error of the profile, such as a format that ES lacks, would end it.
            found = call("glslangValidator", "-G", "--aml", "--amb", "-o", str(Path(name) / "out.spv"), str(source))
        messages = _messages(found, expanded, shift)
        return [m for m in messages if _STRICT_TEXT.search(m.text)]

    def _kept(self, stage: str, text: str) -> Path | None:
        if self._folder is None:
            return None
        return self._folder / f"{stage}-{hashlib.sha256(text.encode()).hexdigest()[:40]}.spv"

    def _run(self, expanded: Expanded, *command: str) -> None:
        found = call(*command)
        if found:
            messages = _messages(found, expanded, 0)
            raise ShaderError(expanded.name, f"{command[0]} refuses it", messages or [ShaderMessage("", 0, found)])


def call(*command: str) -> str:
    """What a program says where it fails; "" where it doesn't."""
    done = subprocess.run(command, capture_output=True, text=True, timeout=_TIMEOUT_S, check=False)
    return "" if done.returncode == 0 else (done.stdout + done.stderr).strip() or f"{command[0]} failed"


def _messages(log: str, expanded: Expanded, shift: int) -> list[ShaderMessage]:
    messages = []
    for line in log.splitlines():
        place = _PLACE.match(line)
        if place is None:
            continue
        number = int(place["line"]) - shift
        where = expanded.table[number - 1] if 0 < number <= len(expanded.table) else ("", 0)
        messages.append(ShaderMessage(*where, place["text"].strip()))
    return messages
