"""Blocks from dataclasses: every field is read back in a shader, at odd values."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from typing import Annotated, Any

import numpy as np
import pytest

from planetfall.engine.blocks.layout import (
    IVec2,
    IVec3,
    IVec4,
    Mat3,
    Mat4,
    UInt,
    UVec2,
    UVec4,
    Vec2,
    Vec3,
    Vec4,
    array,
    zeros,
)
from planetfall.engine.gpu import FormatError, StructLayout


@dataclass
class Inner:
    """Ends with a vec3: nothing may move into its last word."""

    a: int
    b: Vec3


@dataclass
class Layer:
    base_m: Annotated[float, "m"]
    drift: Vec2
    kind: int
    shares: Annotated[Any, array(float, 2)]
    inner: Inner
    turn: Mat3
    on: bool


@dataclass
class Single:
    """4 bytes in std430, 16 in std140."""

    x: float


def inner(start: int) -> Inner:
    return Inner(start, (start + 0.25, start + 0.5, start + 0.75))


def layer(start: int) -> Layer:
    turn = np.arange(9.0).reshape(3, 3) - start
    return Layer(
        start + 0.125, (-float(start), 0.5), -start, (start + 1.5, start + 2.5), inner(start + 3), turn, start > 100
    )


@dataclass
class Odd:
    """Every rule of std140 that is easy to get wrong, in an awkward order."""

    a: float
    b: Vec2
    c: float
    d: Vec3
    e: float  # fits into the last word of the vec3
    f: Annotated[Any, array(float, 3)]
    g: bool
    h: Annotated[Any, array(Vec3, 2)]
    i: int
    j: Mat4
    k: IVec2
    m: UInt
    n: UVec4
    o: Annotated[Any, array(Vec2, 3)]
    p: IVec4
    q: UVec2
    r: Annotated[Any, array(Vec4, 6)]
    s: Annotated[Any, array(int, 2)]
    t: float
    u: Single
    v: float
    w: Annotated[Any, array(Single, 3)]
    x: IVec3
    z: Annotated[Any, array(Layer, 3)]
    aa: Inner
    bb: float
    cc: Annotated[Any, array(Mat3, 2)]


def odd_values() -> Odd:
    return Odd(
        a=1.5,
        b=(2.5, 3.5),
        c=-4.25,
        d=(5.5, 6.5, 7.5),
        e=8.125,
        f=(9.5, 10.5, 11.5),
        g=True,
        h=((12.5, 13.5, 14.5), (15.5, 16.5, 17.5)),
        i=-18,
        j=np.arange(16.0).reshape(4, 4) + 20.5,
        k=(-41, 42),
        m=0xFEDCBA98,
        n=(43, 44, 45, 0xFFFFFFFF),
        o=np.arange(6.0).reshape(3, 2) - 50.5,
        p=(-1, 2, -3, 4),
        q=(7, 8),
        r=np.arange(24.0).reshape(6, 4) * 1.25,
        s=(-60, 61),
        t=62.5,
        u=Single(63.5),
        v=64.5,
        w=[Single(65.5 + k) for k in range(3)],
        x=(-68, 69, -70),
        z=[layer(80 + 20 * k) for k in range(3)],
        aa=inner(140),
        bb=141.5,
        cc=np.arange(18.0).reshape(2, 3, 3) / 8,
    )


_BITS = """
uint bits(float v) { return floatBitsToUint(v); }
uint bits(int v) { return uint(v); }
uint bits(uint v) { return v; }
uint bits(bool v) { return uint(v); }
"""


def _numbers(place: str, value: Any) -> list[tuple[str, Any]]:
    """Every number of a value and where GLSL finds it."""
    if dataclasses.is_dataclass(value):
        parts = [(f"{place}.{f.name}", getattr(value, f.name)) for f in dataclasses.fields(value)]
    elif isinstance(value, (tuple, list, np.ndarray)):
        parts = [(f"{place}[{k}]", part) for k, part in enumerate(value)]
    else:
        return [(place, value)]
    return [number for part in parts for number in _numbers(*part)]


def _reads() -> tuple[str, np.ndarray]:
    """Statements that store every number of the block, and what they must be, as 32-bit words."""
    numbers = _numbers("odd", odd_values())
    words = [np.float32(v).view("u4") if isinstance(v, float) else int(v) & 0xFFFFFFFF for _, v in numbers]
    return "\n".join(f"if (index == {k}u) y = bits({p});" for k, (p, _) in enumerate(numbers)), np.array(words, "u4")


@pytest.mark.parametrize("layout", ["std140", "std430"])
def test_every_field_arrives_in_the_shader(run_compute, scope, layout):
    statements, expected = _reads()
    made = StructLayout(Odd, layout)
    if layout == "std140":
        block = scope.uniform_block(Odd, 5)
        block.write(odd_values())
        bind, header = block.bind, block.layout.block(5, "odd") + _BITS
        assert block.buffer.read() == made.pack(odd_values())
    else:
        buffer = scope.buffer(made.pack(odd_values()))
        bind, header = lambda: buffer.bind_to_storage_buffer(5), made.block(5, "odd", storage=True) + _BITS
    out = run_compute(statements, {}, {"y": "uint"}, header=header, count=len(expected), setup=lambda _: bind())
    np.testing.assert_array_equal(out["y"], expected)


def test_driver_agrees_on_offsets(scope):
    made = StructLayout(Odd)
    reads = " + ".join(f"float({place})" for place, _ in _numbers("odd", odd_values()))
    text = f"{made.block(5, 'odd')}\nlayout(local_size_x=1) in; layout(std430, binding=0) buffer O {{ float y; }};\n"
    scope.gpu.shaders.add_virtual("test/offsets.comp", f"{text}void main() {{ y = {reads}; }}")
    program = scope.compute("test/offsets.comp").mgl
    assert program["Odd"].size == made.size


@dataclass
class Record:
    """Numbers of all kinds, with gaps between them."""

    on: bool
    at: Vec3
    share: float
    parts: Annotated[Any, array(Inner, 2)]
    name: UVec2
    turn: Mat4


@pytest.mark.parametrize("layout", ["std140", "std430"])
def test_a_record_of_numpy_has_the_same_bytes(layout):
    made = StructLayout(Record, layout)
    record = np.zeros((), made.dtype)
    parts, turn = [inner(3), inner(9)], np.arange(16.0).reshape(4, 4)
    record["on"], record["at"], record["share"], record["name"], record["turn"] = True, (1, -2, 3), 0.1, (7, 8), turn
    record["parts"]["a"], record["parts"]["b"] = [p.a for p in parts], [p.b for p in parts]
    assert record.tobytes() == made.pack(Record(True, (1.0, -2.0, 3.0), 0.1, parts, (7, 8), turn))
    with pytest.raises(FormatError, match=r"Layer\.turn: numpy has no mat3 with gaps"):
        _ = StructLayout(Layer, "std430").dtype


def test_names_and_units_in_glsl():
    made = StructLayout(Layer)
    inner_text = "struct Inner {\n    int a;\n    vec3 b;\n};\n"
    guarded = f"#ifndef PF_STRUCT_Inner\n#define PF_STRUCT_Inner\n{inner_text}#endif\n"
    assert made.glsl.startswith(guarded + "struct Layer {\n")
    assert "\n    float base_m;  // m\n" in made.glsl and "\n    float shares[2];\n    Inner inner;\n" in made.glsl
    block = made.block(3, "layer")
    assert "layout(std140, binding = 3) uniform Layer {\n" in block and block.endswith("    bool on;\n} layer;\n")


def test_mappings_and_records_stand_for_a_dataclass():
    made = StructLayout(Layer)
    values = dataclasses.asdict(layer(80))
    assert made.pack(values) == made.pack(layer(80))
    record = np.zeros(1, [("a", "i4"), ("b", "f8", 3)])
    record[0] = (83, (83.25, 83.5, 83.75))
    assert made.pack({**values, "inner": record[0]}) == made.pack(values)
    several = dataclasses.make_dataclass("Several", [("all", Annotated[Any, array(Inner, 2)])])
    twice = np.repeat(record, 2)
    assert StructLayout(several).pack(several(twice)) == StructLayout(several).pack({"all": [inner(83)] * 2})


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"wind": 1.0}, r"Layer has no field wind; its fields are base_m, drift, kind"),
        ({"kind": None}, r"Layer\.kind needs 1 numbers for int, shape \(\)"),
        ({"kind": 1.5}, r"Layer\.kind needs 1 numbers for int"),
        ({"base_m": (1.0, 2.0)}, r"Layer\.base_m needs 1 numbers for float"),
        ({"base_m": 1e39}, r"Layer\.base_m needs 1 numbers for float"),
        ({"drift": 1.0}, r"Layer\.drift needs 2 numbers for vec2"),
        ({"drift": np.zeros((1, 2))}, r"Layer\.drift needs 2 numbers for vec2"),
        ({"shares": [1.0] * 3}, r"Layer\.shares needs 2 numbers for float, shape \(2,\)"),
        ({"turn": np.eye(4)}, r"Layer\.turn needs 9 numbers for mat3, shape \(3, 3\)"),
        ({"turn": np.eye(3).ravel()}, r"Layer\.turn needs 9 numbers for mat3"),
        ({"inner": 3.0}, r"Layer\.inner needs a Inner or a mapping with its fields: found 3\.0"),
        ({"inner": {"a": 1}}, r"Layer\.inner lacks b; its fields are a, b"),
        ({"inner": {"a": 1, "b": (0.0, 1.0)}}, r"Layer\.inner\.b needs 3 numbers for vec3"),
    ],
)
def test_what_does_not_fit_is_named(change, message):
    values = dataclasses.asdict(layer(80))
    with pytest.raises(FormatError, match=message):
        StructLayout(Layer).pack(values | change)
    several = dataclasses.make_dataclass("Several", [("all", Annotated[Any, array(Layer, 2)])])
    with pytest.raises(FormatError, match=message.replace("Layer", r"Several\.all\[1\]", 1)):
        StructLayout(several).pack({"all": [values, values | change]})
    with pytest.raises(FormatError, match=r"Several\.all needs 2 of Layer"):
        StructLayout(several).pack({"all": [values]})


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
    odd = odd_values()
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
    odd = odd_values()
    block.write(odd)
    tracemalloc.start()
    for k in range(100):
        odd.a = float(k)
        block.write(odd)
    current, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert current < 20_000


def test_a_block_with_defaults_is_refused():
    for made in (field(default=1.0), field(default_factory=float)):
        loose = dataclasses.make_dataclass("Loose", [("a", int), ("b", float, made)])
        with pytest.raises(FormatError, match=r"Loose\.b has a default: .* gives every field.* zeros\(Loose\)"):
            StructLayout(loose)
        with pytest.raises(FormatError, match=r"Loose\.b has a default"):
            StructLayout(dataclasses.make_dataclass("Holder", [("all", Annotated[Any, array(loose, 2)])]))


def test_zeros():
    made = zeros(Odd)
    assert isinstance(made.u, Single) and [type(part) for part in made.z] == [Layer] * 3
    assert StructLayout(Odd).pack(made) == bytes(StructLayout(Odd).size)


@dataclass
class Flat:
    """What flat arrays may hold, in an awkward order."""

    a: float
    b: Vec2
    c: int
    d: Vec3
    e: bool
    inner: Inner
    f: UVec2
    g: IVec3
    h: UInt
    i: Vec4
    j: IVec4


def flat(start: int) -> Flat:
    k = float(start)
    return Flat(
        k, (k + 0.5, -k), -start, (k, 1e-40, k + 0.25), start % 2 > 0, inner(start), (start, 0xFFFFFFFF),
        (-1, start, 0), 0x80000001, (k, -0.0, 3e38, k + 0.125), (start, -2, 3, -0x80000000),
    )  # fmt: skip


@dataclass
class Flats:
    before: float
    several: Annotated[Any, array(Flat, 3, flat=True)]
    after: int


def test_flat_arrays_have_the_same_bytes_and_arrive_bit_for_bit(run_compute, scope):
    values = Flats(1.5, [flat(7 + 3 * k) for k in range(3)], -9)
    plain = dataclasses.make_dataclass(
        "Flats", [("before", float), ("several", Annotated[Any, array(Flat, 3)]), ("after", int)]
    )
    assert StructLayout(Flats).pack(values) == StructLayout(plain).pack(values)
    numbers = _numbers("flats", values)
    words = [np.float32(v).view("u4") if isinstance(v, float) else int(v) & 0xFFFFFFFF for _, v in numbers]
    places = [place.replace("flats.several[", "flats_several(", 1) for place, _ in numbers]
    places = [p.replace("]", ")", 1) if "several(" in p else p for p in places]
    statements = "\n".join(f"if (index == {k}u) y = bits({p});" for k, p in enumerate(places))
    block = scope.uniform_block(Flats, 5)
    block.write(values)
    header = block.layout.block(5, "flats") + _BITS
    assert "const int FLATS_SEVERAL = 3;\n" in header
    out = run_compute(statements, {}, {"y": "uint"}, header=header, count=len(words), setup=lambda _: block.bind())
    np.testing.assert_array_equal(out["y"], np.array(words, "u4"))


def test_what_cannot_be_flat_is_told():
    with pytest.raises(FormatError, match="flat arrays are of dataclasses"):
        array(Vec4, 2, flat=True)
    for element, layout in ((Layer, "std140"), (Inner, "std430")):
        several = dataclasses.make_dataclass("Several", [("all", Annotated[Any, array(element, 2, flat=True)])])
        with pytest.raises(FormatError, match=r"Several\.all: flat arrays are of std140 dataclasses"):
            StructLayout(several, layout)
