"""No stage that any setting runs has doubles: players' GPUs run them at 1/32 to 1/64 of float, if at all."""

from __future__ import annotations

import re
import shutil

import pytest

import planetfall as pf
from planetfall.engine.gpu.shaders import ShaderLibrary
from planetfall.engine.gpu.spirv import ReferenceCompiler

pytestmark = pytest.mark.skipif(shutil.which("glslangValidator") is None, reason="glslang is not installed")

FLOAT64 = 10
"""SPIR-V 1.0, 3.31: the capability."""


@pytest.fixture
def built(monkeypatch):
    """The stages of all programs that are linked from here on: [(stage, text)]."""
    stages, link = {}, ShaderLibrary.acquire

    def acquire(library, expanded, name, at_once=False):
        stages.update({each.key: (stage, each) for stage, each in expanded.items()})
        return link(library, expanded, name, at_once)

    monkeypatch.setattr(ShaderLibrary, "acquire", acquire)
    return stages


def with_doubles(stages):
    """Names of stages whose SPIR-V asks for doubles. Only texts with a word for them are compiled."""
    compiler = ReferenceCompiler()
    words = re.compile(r"double|dvec|dmat|LF\b", re.IGNORECASE)
    asked = [(stage, each) for stage, each in stages.values() if words.search(each.text)]
    return {each.name for stage, each in asked if FLOAT64 in compiler.compile(stage, each).capabilities}


def test_what_has_doubles_is_found(built, gpu, scope):
    text = "layout(local_size_x = 1) in;\nlayout(std430, binding = 0) buffer B { float x; };\n"
    gpu.shaders.add_virtual("test/double.comp", f"{text}void main() {{ double y = x; x = float(y * y); }}\n")
    gpu.shaders.add_virtual("test/float.comp", f"{text}void main() {{ float y = x; x = y * y; }} // no double\n")
    scope.compute("test/double.comp")
    scope.compute("test/float.comp")
    assert len(built) == 2 and with_doubles(built) == {"test/double.comp"}


@pytest.mark.parametrize(
    ("preset", "quality", "backend"),
    [
        *(("earth", "low", "grid"), ("earth", "medium", "grid"), ("earth", "high", "grid")),
        *(("moon", "medium", "grid"), ("mars", "high", "grid")),
        *((preset, "medium", tiles) for preset in ("earth", "moon", "mars") for tiles in ("quadtree", "icosphere")),
    ],
)
def test_settings_run_without_doubles(built, preset, quality, backend):
    overrides = {"terrain.backend": backend}
    with pf.load_scene(preset) as scene, pf.Renderer(scene, (64, 36), quality, overrides) as renderer:
        for altitude_m in (2.0, 4e5):
            renderer.render(pf.Camera.at(-3.0, 41.5, altitude_m, pitch_deg=-20.0, above="ground"))
    assert len(built) > 40 and with_doubles(built) == set()
