"""The reference compiler and what is read from its SPIR-V: each fault that is looked for is planted once."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from planetfall.engine.gpu import FormatError, GpuError, ShaderError
from planetfall.engine.gpu.preprocess import ShaderSources
from planetfall.engine.gpu.spirv import Module, ReferenceCompiler, accesses, faults, usage
from planetfall.engine.gpu.spirv import compiler as compiler_module

pytestmark = pytest.mark.skipif(shutil.which("glslangValidator") is None, reason="glslang is not installed")

GROUP = """layout(local_size_x = 64) in;
shared float s_sum[64];
layout(binding = 0, r32f) uniform writeonly image2D u_to;
"""


def expanded(text: str, stage: str = "compute"):
    sources = ShaderSources([])
    sources.add_virtual("planted", text)
    return stage, sources.expand("planted")


def compiled(text: str, stage: str = "compute") -> Module:
    return ReferenceCompiler().compile(*expanded(text, stage))


def found(text: str, stage: str = "compute") -> list[str]:
    return faults(stage, compiled(text, stage))


def test_text_that_is_refused_names_its_line():
    with pytest.raises(ShaderError, match="glslangValidator refuses it") as caught:
        compiled("layout(local_size_x = 1) in;\nstruct Path { float length; };\nvoid main() {\n"
                 "    Path p = Path(1.0);\n    float x = p.length * nothing;\n}\n")  # fmt: skip
    assert (caught.value.file, caught.value.line) == ("planted", 5)


def test_a_constant_place_past_an_array_is_refused():
    with pytest.raises(ShaderError, match="out of range"):
        compiled("layout(local_size_x = 1) in;\nvoid main() { float a[3] = float[3](1.0, 2.0, 3.0); a[3] = 0.0; }\n")


def test_only_text_that_is_new_is_compiled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    text = "layout(local_size_x = 1) in;\nvoid main() { }\n"
    first = ReferenceCompiler(tmp_path).compile(*expanded(text))
    monkeypatch.setattr(compiler_module, "call", lambda *command: pytest.fail("compiled again"))
    again = ReferenceCompiler(tmp_path).compile(*expanded(text))
    assert first.names == again.names and len(list(tmp_path.iterdir())) == 1


def test_without_the_compiler_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("PATH", "/nowhere")
    with pytest.raises(GpuError, match="apt-get install glslang-tools spirv-tools"):
        ReferenceCompiler()


@pytest.mark.parametrize("data", [b"", b"\x03\x02\x23\x07" * 4, b"no SPIR-V at all here, but words...."])
def test_what_is_no_spirv_is_refused(data: bytes):
    with pytest.raises(FormatError, match=r"no SPIR-V|cut off"):
        Module(data)


# -- what a stage reads and writes ----------------------------------------------------------------------------------

TOUCHES = """
layout(local_size_x = 1) in;
layout(binding = 0) uniform sampler2D u_sampled;
layout(binding = 1) uniform sampler2D u_sized;
layout(binding = 2) uniform sampler2D u_never;
layout(binding = 0, r32f) uniform image2D u_both;
layout(binding = 1, r32f) uniform writeonly image2D u_written;
layout(binding = 2, r32ui) uniform uimage2D u_counted;
layout(std430, binding = 3) buffer In { float values[]; } b_in;
layout(std430, binding = 4) buffer Out { float results[]; };
layout(std430, binding = 5) buffer Count { uint count; };
layout(std430, binding = 6) buffer Sized { float sized[]; };
layout(std140, binding = 7) uniform Block { float scale; };
float through(sampler2D map) { return texture(map, vec2(0.5)).x; }
float unused() { return texture(u_never, vec2(0.5)).x; }
void main() {
    ivec2 size = textureSize(u_sized, 0);
    float x = through(u_sampled) * scale + b_in.values[size.x] + imageLoad(u_both, size).x;
    imageStore(u_both, size, vec4(x));
    imageStore(u_written, size, vec4(x));
    imageAtomicAdd(u_counted, size, 1u);
    results[atomicAdd(count, 1u)] = float(sized.length());
}
"""


def test_accesses_are_those_of_instructions_that_are_reached():
    touched = {a.variable.name: (a.variable.kind, a.reads, a.writes) for a in accesses(compiled(TOUCHES))}
    assert touched == {
        "u_sampled": ("texture", True, False), "u_both": ("image", True, True), "u_written": ("image", False, True),
        "u_counted": ("image", True, True), "b_in": ("storage", True, False), "Out": ("storage", False, True),
        "Count": ("storage", True, True), "Block": ("uniform", True, False),
    }  # fmt: skip
    bindings = {v.name: v.binding for v in compiled(TOUCHES).variables.values()}
    assert bindings["u_never"] == 2 and bindings["Out"] == 4


def test_usage_counts_what_a_driver_limits():
    found = usage("compute", compiled(TOUCHES))
    assert found["COMPUTE_SHADER_STORAGE_BLOCKS"] == 3 and found["SHADER_STORAGE_BUFFER_BINDINGS"] == 6
    assert found["COMPUTE_IMAGE_UNIFORMS"] == 3 and found["COMPUTE_TEXTURE_IMAGE_UNITS"] == 1
    assert (found["COMPUTE_WORK_GROUP_INVOCATIONS"], found["COMPUTE_SHARED_MEMORY_SIZE"]) == (1, 0)
    shared = "layout(local_size_x = 8, local_size_y = 4) in;\nshared vec3 s_a[10];\nshared uint s_b;\n"
    found = usage(
        "compute", compiled(shared + "void main() { s_a[gl_LocalInvocationIndex % 10u] = vec3(1.0); s_b = 1u; }")
    )
    assert (found["COMPUTE_WORK_GROUP_INVOCATIONS"], found["COMPUTE_SHARED_MEMORY_SIZE"]) == (32, 124)


# -- what compiles here and fails elsewhere -------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "why"),
    [("length", "GLSL's own"), ("filter", "reserved"), ("texture2D", "reserved"), ("noise1", "GLSL's own")],
)
def test_names_that_some_version_of_the_language_has(name: str, why: str):
    text = f"{GROUP}void main() {{ float {name}_ok = 1.0; imageStore(u_to, ivec2(0), vec4({name}_ok)); }}\n"
    assert found(text) == []
    if name == "filter":  # reserved in this version, too
        with pytest.raises(ShaderError):
            compiled(text.replace("filter_ok", "filter"))
    else:
        (only,) = found(text.replace(f"{name}_ok", name))
        assert repr(name) in only and why in only


def test_an_output_that_nothing_writes():
    text = "out vec4 o_a;\nout vec4 o_b;\nvoid main() { o_a = vec4(1.0); }\n"
    (only,) = found(text, "fragment")
    assert "'o_b'" in only
    assert found(text.replace("o_a = vec4(1.0);", "o_a = vec4(1.0); o_b = o_a;"), "fragment") == []


EVEN = {
    "plain": "s_sum[k] = 1.0; barrier(); x = s_sum[63 - k];",
    "a sum": "for (uint n = 32u; n > 0u; n >>= 1) { barrier(); if (k < n) s_sum[k] += s_sum[k + n]; }",
    "the group's number": "if (gl_WorkGroupID.x > 3u) { barrier(); }",
    "a loop over strides": "do { x += 1.0; k += 64u; } while (k < 100u); barrier();",
    "a condition before": "if (k < 3u) { x = 1.0; } barrier();",
}
UNEVEN = {
    "a condition": "if (k < 3u) { barrier(); }",
    "its other branch": "if (k < 3u) { x = 1.0; } else { barrier(); }",
    "left before": "if (k > 3u) return; barrier();",
    "a loop": "for (uint n = 0u; n < k; n++) { barrier(); }",
    "a loop that some leave": "for (uint n = 0u; n < 8u; n++) { if (n > k) break; barrier(); }",
    "a value of it": "float mine = float(k) * 0.5; bool few = mine < 3.0; if (few) { barrier(); }",
    "stored under it": "bool few = false; if (k < 3u) { few = true; } if (few) { barrier(); }",
    "in a function": "if (k < 3u) { waits(); }",
    "given to a function": "waits_if(k < 3u);",
    "an atomic's": "if (atomicAdd(s_count, 1u) == 0u) { barrier(); }",
}
WAITS = (
    GROUP + "shared uint s_count;\nvoid waits() { barrier(); }\nvoid waits_if(bool yes) { if (yes) { barrier(); } }\n"
)
MAIN = "void main() {{ uint k = gl_LocalInvocationIndex; float x = 0.0; {} imageStore(u_to, ivec2(k), vec4(x)); }}\n"


@pytest.mark.parametrize("body", EVEN.values(), ids=list(EVEN))
def test_barriers_that_all_reach(body: str):
    assert found(WAITS + MAIN.format(body)) == []


@pytest.mark.parametrize("body", UNEVEN.values(), ids=list(UNEVEN))
def test_barriers_that_a_part_may_reach(body: str):
    (only,) = found(WAITS + MAIN.format(body))
    assert "barrier" in only


@pytest.mark.parametrize(
    ("statement", "refused"),
    [
        ("float x = 1;", True), ("vec2 x = vec2(1.0) * 2;", True), ("uint x = 1;", True), ("float x = 1.0;", False),
        ("vec2 x = vec2(1, 2);", False), ("uint x = 1u << 3;", False), ("float x = min(1.0, 2);", True),
    ],
)  # fmt: skip
def test_conversions_that_nobody_wrote(statement: str, refused: bool):
    stage, text = expanded(f"layout(local_size_x = 1) in;\nvoid main() {{\n    {statement}\n}}\n")
    messages = ReferenceCompiler().strict(stage, text)
    assert bool(messages) == refused
    assert all((m.file, m.line) == ("planted", 3) for m in messages)
