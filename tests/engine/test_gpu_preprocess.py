"""Shader sources without a GPU: includes, defines, contracts, and driver logs mapped back to files."""

from __future__ import annotations

import pytest

from planetfall.engine.gpu.errors import ShaderError, ShaderMessage
from planetfall.engine.gpu.preprocess import ShaderSources, map_log
from planetfall.engine.made_shaders import MADE


@pytest.fixture
def sources(tmp_path):
    def write(**files: str) -> ShaderSources:
        for name, text in files.items():
            path = tmp_path / f"{name.replace('__', '/')}.glsl"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        return ShaderSources([tmp_path])

    return write


def _code(text: str) -> list[str]:
    return [line for line in text.splitlines() if line and not line.startswith("#")]


def test_files_are_included_once_and_lines_map_back(sources):
    library = sources(
        a='int a0;\n#include "sub/b.glsl"\n#include "c.glsl"\nint a3;', sub__b='#include "c.glsl"\nint b1;', c="int c0;"
    )
    out = library.expand("a.glsl")
    assert _code(out.text) == ["int a0;", "int c0;", "int b1;", "int a3;"]
    assert out.files == {"a.glsl", "sub/b.glsl", "c.glsl"}
    lines = out.text.splitlines()
    assert len(lines) == len(out.table)
    for text, place in {"int a3;": ("a.glsl", 4), "int b1;": ("sub/b.glsl", 2), "int c0;": ("c.glsl", 1)}.items():
        assert out.table[lines.index(text)] == place


def test_cycles_end(sources):
    library = sources(a='#include "b.glsl"\nint a;', b='#include "a.glsl"\nint b;')
    assert _code(library.expand("a.glsl").text) == ["int b;", "int a;"]


def test_a_file_first_included_inside_an_if_comes_again_outside(sources):
    library = sources(a='#ifdef X\n#include "c.glsl"\n#endif\n#include "c.glsl"\n#include "c.glsl"', c="int c;")
    text = library.expand("a.glsl").text
    assert text.count("int c;") == 2
    assert text.count("#ifndef PF_INCLUDED_c_glsl") == 2


def test_defines_version_and_extensions_come_first(sources):
    library = sources(a="#version 330\n#pragma once\nint a;\n#extension GL_ARB_foo : enable\n")
    text = library.expand("a.glsl", {"ON": True, "N": 3, "F": 0.5, "GONE": None, "OFF": False}).text
    assert text.splitlines()[:6] == [
        "#version 430 core", "#extension GL_ARB_foo : enable",
        "#define F 0.5", "#define N 3", "#define OFF 0", "#define ON 1",
    ]  # fmt: skip
    assert text.count("#version") == 1 and text.count("#extension") == 1
    with pytest.raises(ShaderError, match="'A B' is not a GLSL identifier"):
        library.expand("a.glsl", {"A B": 1})


def test_comments_are_left_alone(sources):
    library = sources(a='// #include "gone.glsl"\n/*\n#include "gone.glsl"\n*/ int a; // /*\nint b;')
    text = library.expand("a.glsl").text
    assert "int b;" in text
    assert "#include" not in text  # moderngl would try to resolve it


def test_missing_files_are_explained(sources):
    library = sources(a='int a;\n#include "comon/safe.glsl"', common__safe="int s;")
    with pytest.raises(ShaderError) as caught:
        library.expand("a.glsl")
    assert (caught.value.file, caught.value.line) == ("a.glsl", 2)
    assert "did you mean 'common/safe.glsl'?" in str(caught.value)
    with pytest.raises(ShaderError, match=r"no file 'nothing\.frag' under"):
        library.expand("nothing.frag")
    with pytest.raises(ShaderError, match="malformed #include") as caught:
        sources(b="#include safe.glsl").expand("b.glsl")
    assert (caught.value.file, caught.value.line) == ("b.glsl", 1)


def test_relative_to_the_including_file_as_well(sources):
    library = sources(sub__a='#include "b.glsl"', sub__b="int b;")
    assert "sub/b.glsl" in library.expand("sub/a.glsl").files


def test_contracts_have_a_default_a_provider_and_one_owner(sources):
    library = sources(a='#include "contract/air.glsl"', common__air="int none;", sky__air="int real;")
    plain = library.expand("a.glsl")
    assert "int none;" in plain.text and plain.contracts == {"air"}
    generation = library.generation
    library.provide("air", "sky/air.glsl", "sky")
    assert library.generation > generation
    assert "int real;" in library.expand("a.glsl").text
    with pytest.raises(ValueError, match=r"'fog' offers fog\.glsl, but 'sky' already provides sky/air\.glsl"):
        library.provide("air", "fog.glsl", "fog")
    library.withdraw("fog")
    library.withdraw("sky")
    assert library.expand("a.glsl").key == plain.key


def test_virtual_files_win_and_count_as_changes(sources):
    library = sources(a='#include "generated/x.glsl"')
    library.add_virtual("generated/x.glsl", "int one;")
    generation = library.generation
    library.add_virtual("generated/x.glsl", "int one;")
    assert library.generation == generation
    library.add_virtual("generated/x.glsl", "int two;")
    assert library.generation == generation + 1
    assert "int two;" in library.expand("a.glsl").text


def test_made_files_are_included_like_files(sources, monkeypatch):
    monkeypatch.setitem(MADE, "generated/y.glsl", lambda: "int one;\nint two;")
    library = sources(a='#include "generated/y.glsl"', b='#include "generated/z.glsl"')
    expanded = library.expand("a.glsl")
    line = expanded.text.splitlines().index("int two;")
    assert expanded.table[line] == ("generated/y.glsl", 2), "messages of compilers name the file"
    with pytest.raises(ShaderError, match=r"did you mean 'generated/y\.glsl'"):
        library.expand("b.glsl")
    library.add_virtual("generated/y.glsl", "int own;")
    assert "int own;" in library.expand("a.glsl").text


@pytest.mark.parametrize(
    ("line", "text"),
    [
        ("0:{n}(33): error: `foo' undeclared", "error: `foo' undeclared"),  # Mesa
        ('0({n}) : error C1503: undefined variable "foo"', 'error C1503: undefined variable "foo"'),  # NVIDIA
        ("ERROR: 0:{n}: 'foo' : undeclared identifier", "error: 'foo' : undeclared identifier"),  # AMD, Intel, macOS
        ("WARNING: 0:{n}: 'foo' : unused", "warning: 'foo' : unused"),
    ],
)
def test_logs_of_all_drivers(sources, line, text):
    library = sources(v='#include "c.glsl"\nint v;', f='int f0;\n#include "c.glsl"\nint f2;', c="int c0;\nint c1;")
    stages = {"vertex": library.expand("v.glsl"), "fragment": library.expand("f.glsl", {"A": 1})}
    number = stages["fragment"].text.splitlines().index("int c1;") + 1
    log = f"GLSL Compiler failed\n\nfragment_shader\n===============\n{line.format(n=number)}\n\n"
    assert map_log(log, stages) == [ShaderMessage("c.glsl", 2, text)]
    assert str(map_log(log, stages)[0]) == f"c.glsl:2: {text}"
    # NVIDIA link logs name the stage their own way
    linked = f"GLSL Linker failed\n\nProgram\n=======\nVertex info\n-----------\n{line.format(n=2)}\nerror: no main"
    first, second = map_log(linked, stages)
    assert first.file == "v.glsl" and second == ShaderMessage("", 0, "error: no main")
    assert map_log(f"fragment_shader\n{line.format(n=999)}", stages)[0].file == ""
    assert map_log(f"fragment_shader\n{line.format(n=2)}", stages)[0].file == "<defines>"
