"""Blocks from dataclasses: every field is read back in a shader, at odd values."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from typing import Annotated, Any

import numpy as np
import pytest

from planetfall.engine.gpu import FormatError, StructLayout
from planetfall.engine.gpu.layout import IVec2, IVec4, Mat4, UInt, UVec2, UVec4, Vec2, Vec3, Vec4, array


@dataclass
class Odd:
    """Every rule of std140 that is easy to get wrong, in an awkward order."""

    a: float = 1.5
    b: Vec2 = (2.5, 3.5)
    c: float = -4.25
    d: Vec3 = (5.5, 6.5, 7.5)
    e: float = 8.125  # fits into the last word of the vec3
    f: Annotated[Any, array(float, 3)] = (9.5, 10.5, 11.5)
    g: bool = True
    h: Annotated[Any, array(Vec3, 2)] = ((12.5, 13.5, 14.5), (15.5, 16.5, 17.5))
    i: int = -18
    j: Mat4 = field(default_factory=lambda: np.arange(16.0).reshape(4, 4) + 20.5)
    k: IVec2 = (-41, 42)
    m: UInt = 0xFEDCBA98
    n: UVec4 = (43, 44, 45, 0xFFFFFFFF)
    o: Annotated[Any, array(Vec2, 3)] = field(default_factory=lambda: np.arange(6.0).reshape(3, 2) - 50.5)
    p: IVec4 = (-1, 2, -3, 4)
    q: UVec2 = (7, 8)
    r: Annotated[Any, array(Vec4, 6)] = field(default_factory=lambda: np.arange(24.0).reshape(6, 4) * 1.25)
    s: Annotated[Any, array(int, 2)] = (-60, 61)
    t: float = 62.5


def _reads() -> tuple[str, np.ndarray]:
    """Statements that store every scalar of the block, and what they must be, as 32-bit words."""
    statements, expected = [], []
    for member in StructLayout(Odd).members:
        value = np.asarray(getattr(Odd(), member.name)).astype(member.type.base)
        rows = value.reshape(member.type.count or 1, member.type.columns, member.type.components)
        for e, element in enumerate(rows):
            for k, column in enumerate(element):
                for c, number in enumerate(column):
                    part = f"odd.{member.name}" + (f"[{e}]" if member.type.count else "")
                    part += f"[{k}]" if member.type.columns > 1 else ""
                    part += f"[{c}]" if member.type.components > 1 else ""
                    convert = "floatBitsToUint" if member.type.base == "f4" else "uint"
                    statements.append(f"if (index == {len(expected)}u) y = {convert}({part});")
                    expected.append(np.array(number).view("u4"))
    return "\n".join(statements), np.array(expected, "u4").ravel()


@pytest.mark.parametrize("layout", ["std140", "std430"])
def test_every_field_arrives_in_the_shader(run_compute, scope, layout):
    statements, expected = _reads()
    made = StructLayout(Odd, layout)
    if layout == "std140":
        block = scope.uniform_block(Odd, 5)
        block.write(Odd())
        bind, header = block.bind, block.layout.block(5, "odd")
        assert block.buffer.read() == made.pack(Odd())
    else:
        buffer = scope.buffer(made.pack(Odd()))
        bind, header = lambda: buffer.bind_to_storage_buffer(5), made.block(5, "odd", storage=True)
    out = run_compute(statements, {}, {"y": "uint"}, header=header, count=len(expected), setup=lambda _: bind())
    np.testing.assert_array_equal(out["y"], expected)


def test_driver_agrees_on_offsets(scope):
    made = StructLayout(Odd)
    reads = " + ".join(f"float(odd.{m.name}{'[0]' * bool(m.type.count)}{'[0]' * (m.type.columns > 1)}"
                       f"{'[0]' * (m.type.components > 1)})" for m in made.members)  # fmt: skip
    text = f"{made.block(5, 'odd')}\nlayout(local_size_x=1) in; layout(std430, binding=0) buffer O {{ float y; }};\n"
    scope.gpu.shaders.add_virtual("test/offsets.comp", f"{text}void main() {{ y = {reads}; }}")
    program = scope.compute("test/offsets.comp").mgl
    assert program["Odd"].size == made.size


def test_names_in_glsl_and_help():
    @dataclass
    class Small:
        depth_m: float = field(default=0.0, metadata={"help": "metres below\nsea level"})

    assert StructLayout(Small).glsl == "struct Small {\n    float depth_m;  // metres below sea level\n};\n"
    block = StructLayout(Small).block(3, "small")
    assert block.startswith("layout(std140, binding = 3) uniform Small {") and block.endswith("} small;\n")


def test_nested_array_and_bad_types_are_explained():
    with pytest.raises(FormatError, match="one dimension"):
        array(array(Vec4, 2), 3)
    bad = dataclasses.make_dataclass("Bad", [("x", str)])
    with pytest.raises(FormatError, match=r"Bad\.x: <class 'str'> has no GLSL type; use float"):
        StructLayout(bad)
    with pytest.raises(FormatError, match="no fields"):
        StructLayout(dataclasses.make_dataclass("Empty", []))
    with pytest.raises(FormatError, match="is not a dataclass"):
        StructLayout(int)


def test_write_uploads_only_what_changed(scope):
    block = scope.uniform_block(Odd, 5)
    work = scope.gpu.work
    work.reset()
    odd = Odd()
    assert block.write(odd) and not block.write(odd)
    odd.e = 9.0
    assert block.write(odd)
    assert (work.uploads, work.upload_bytes) == (2, 2 * block.layout.size)
    with pytest.raises(FormatError, match=r"Odd\.d needs 3 numbers"):
        block.write(dataclasses.replace(odd, d=(1.0, 2.0)))
    with pytest.raises(FormatError, match=r"Odd\.d needs 3 numbers"):
        block.write(dataclasses.replace(odd, d=1.0))


def test_write_allocates_no_arrays(scope):
    import tracemalloc

    block = scope.uniform_block(Odd, 5)
    odd = Odd()
    block.write(odd)
    tracemalloc.start()
    for k in range(100):
        odd.a = float(k)
        block.write(odd)
    current, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert current < 20_000
