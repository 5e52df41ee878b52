"""Fixtures of all tests: a headless GPU context, a runner for GLSL snippets, and which tests a run takes.

Tests of shader functions hold GLSL against a numpy twin with `run_compute`:

    def test_safe_sqrt(run_compute):
        x = np.linspace(-1, 1, 100)
        out = run_compute("y = safe_sqrt(x);", {"x": x}, {"y": "float"}, header='#include "common/safe.glsl"')
        np.testing.assert_allclose(out["y"], np.sqrt(np.maximum(x, 0)), rtol=1e-6)
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck
from hypothesis import settings as hypothesis_settings
from numpy.typing import NDArray
from tiers import COLLECTED, files_named, of_default

from planetfall import ASSETS, load_scene
from planetfall.engine.gpu import Gpu, GpuScope
from planetfall.engine.gpu.software_threads import OFF
from planetfall.engine.hosts.headless import create_headless
from planetfall.scene.file import PRESETS, describe

# The same cases in every run, and a busy machine is no failure.
hypothesis_settings.register_profile(
    "planetfall", derandomize=True, deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
hypothesis_settings.load_profile("planetfall")

RunCompute = Callable[..., dict[str, NDArray[Any]]]


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--all", action="store_true", default=False, help="run all tests but those marked slow")
    parser.addoption("--slow", action="store_true", default=False, help="run tests marked slow as well")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    config.stash[COLLECTED] = [(item.path.name, item.name) for item in items]
    if not (config.getoption("--all") or config.getoption("--slow")):
        named = files_named(config.args)
        left_out = {item for item in items if item.path not in named and not of_default(item.path.name, item.name)}
        config.hook.pytest_deselected(items=[item for item in items if item in left_out])
        items[:] = [item for item in items if item not in left_out]
    if not config.getoption("--slow"):
        skip = pytest.mark.skip(reason="long sweep: run with --slow")
        for item in items:
            if item.get_closest_marker("slow") is not None:  # not `keywords`, which hold the names of folders too
                item.add_marker(skip)


@pytest.fixture(scope="session", autouse=True)
def own_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """No test, and no program that one starts, reads or writes the user's own cache and settings.

    Tables that one worker of a run has made are there for the others.
    """
    workers = "PYTEST_XDIST_WORKER" in os.environ
    base = tmp_path_factory.getbasetemp()
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PLANETFALL_CACHE", str((base.parent if workers else base) / "cache"))
        patch.setenv("PLANETFALL_CONFIG", str(tmp_path_factory.mktemp("config")))
        yield


@pytest.fixture(scope="session", autouse=True)
def own_processors() -> Iterator[None]:
    """Workers side by side, and the programs that they start, leave their threads to the scheduler.

    A processor for each thread is right for one program: of two, threads would wait for each other beside one that is
    idle.
    """
    with pytest.MonkeyPatch.context() as patch:
        if int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1")) > 1:
            patch.setenv(OFF, "0")
        yield


@pytest.fixture(scope="session", autouse=True)
def clear_skies() -> Iterator[None]:
    """Presets have no clouds in tests, which are about what lies below them and would wait for them.

    Tests of clouds bring their own, or take presets with `planetfall.benchmarks.scenes.preset_scene(name, True)`;
    programs that a test starts see presets as they are.
    """
    kept = [False]

    def clear(source: Any) -> Any:
        found = describe(source)
        preset = found.path.parent == PRESETS / "planets"
        components = {table: part for table, part in found.components.items() if table != "clouds"}
        return replace(found, components=components) if preset and not kept[0] else found

    def whole(source: Any) -> Any:
        kept[0] = True
        try:
            return load_scene(source)
        finally:
            kept[0] = False

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("planetfall.scene.scene.describe", clear)
        patch.setattr("planetfall.benchmarks.scenes.load_scene", whole)
        yield


@pytest.fixture(scope="session")
def gpu() -> Iterator[Gpu]:
    """One headless context for all tests. Fails, and says what to install, where there is no EGL."""
    ctx = create_headless()
    made = Gpu(ctx, [ASSETS / "shaders"])
    yield made
    made.release()
    ctx.release()


@pytest.fixture
def scope(gpu: Gpu) -> Iterator[GpuScope]:
    """A scope for one test; everything in it is freed afterwards, and no GL error may be left behind."""
    made = gpu.scope("test")
    yield made
    made.release()
    assert gpu.ctx.error == "GL_NO_ERROR"


@pytest.fixture
def run_compute(gpu: Gpu) -> Iterator[RunCompute]:
    """Evaluate GLSL on arrays: run_compute(body, inputs, outputs, header="", defines=None, uniforms=None, setup=None).

    body: statements for one element. Each input stands there as a variable of its name, each output is a variable to
    assign; `index` (uint) is the element's number and `count` the number of elements.
    inputs: name -> array (N,) for float, int, uint; (N, 2..4) for vectors; a number or a tuple (one vector) holds for
    all elements. Floating arrays become f32; integers int; unsigned uint; bool arrays become uint.
    outputs: name -> GLSL type ("float", "vec3", "uint", "ivec2", ...), or (components, dtype) such as (3, np.float32).
    header: what stands before main: includes, functions, bindings; lines of the body that start with # go there too.
    uniforms: values for uniforms declared in the header. setup: called with the Compute before it runs, to bind
    textures or buffers (storage bindings 6 and 7 are taken). count: needed only when no input has elements.
    Returns name -> array (N,) or (N, components). Values are bit-exact both ways; NaN stays NaN, denormals may flush.
    """
    scopes: list[GpuScope] = []

    def run(
        body: str,
        inputs: Mapping[str, Any] | None = None,
        outputs: Mapping[str, Any] | None = None,
        header: str = "",
        defines: Mapping[str, Any] | None = None,
        uniforms: Mapping[str, Any] | None = None,
        setup: Callable[[Any], None] | None = None,
        count: int | None = None,
    ) -> dict[str, NDArray[Any]]:
        scope = gpu.scope("run_compute")
        scopes.append(scope)
        arrays = {name: _as_words(name, value) for name, value in (inputs or {}).items()}
        lengths = {name: len(a) for name, a in arrays.items() if len(a) != 1}
        assert len(set(lengths.values())) <= 1, f"inputs differ in length: {lengths}"
        n = count or max(lengths.values(), default=1)
        hoisted = "\n".join(line for line in body.splitlines() if line.lstrip().startswith("#"))
        statements = "\n".join(line for line in body.splitlines() if not line.lstrip().startswith("#"))
        load, data, offset = [], [], 0
        for name, a in arrays.items():
            step = 0 if len(a) == 1 else a.shape[1]
            load.append(_load(name, a, offset, step))
            data.append(a.reshape(-1).view(np.uint32))
            offset += a.size
        kinds = {name: _output_kind(spec) for name, spec in (outputs or {}).items()}
        store, at = [], 0
        for name, (glsl, base, k) in kinds.items():
            load.append(f"{glsl} {name} = {glsl}(0);")
            for j in range(k):
                part = name if k == 1 else f"{name}[{j}]"
                word = {"f": f"floatBitsToUint({part})", "i": f"uint({part})", "u": part}[base]
                store.append(f"pf_out[{at}u + index * {k}u + {j}u] = {word};")
            at += n * k
        newline = "\n    "
        text = f"""
{hoisted}
{header}
layout(local_size_x = 64) in;
layout(std430, binding = 6) readonly buffer PfInputs {{ uint pf_in[]; }};
layout(std430, binding = 7) writeonly buffer PfOutputs {{ uint pf_out[]; }};
void main() {{
    const uint count = {n}u;
    uint index = gl_GlobalInvocationID.x;
    if (index >= count) return;
    {newline.join(load)}
    {{
{statements}
    }}
    {newline.join(store)}
}}
"""
        gpu.shaders.add_virtual("test/run_compute.comp", text)
        compute = scope.compute("test/run_compute.comp", dict(defines or {}))
        for name, value in (uniforms or {}).items():
            compute.set(name, value)
        source = scope.buffer(np.concatenate(data) if data else np.zeros(1, np.uint32))
        target = scope.buffer(reserve=max(4 * at, 4))
        if setup:
            setup(compute)
        source.bind_to_storage_buffer(6)
        target.bind_to_storage_buffer(7)
        compute.run((n + 63) // 64)
        gpu.barrier()
        words = np.frombuffer(target.read(), np.uint32)
        results: dict[str, NDArray[Any]] = {}
        at = 0
        for name, (_, base, k) in kinds.items():
            part = words[at : at + n * k].view({"f": np.float32, "i": np.int32, "u": np.uint32}[base])
            results[name] = part.copy() if k == 1 else part.reshape(n, k).copy()
            at += n * k
        scope.release()
        assert gpu.ctx.error == "GL_NO_ERROR"
        return results

    yield run
    for scope in scopes:
        scope.release()


def _as_words(name: str, value: Any) -> NDArray[Any]:
    """(N, components) array of f4, i4 or u4. A flat sequence that is not an array counts as one vector."""
    a = np.asarray(value)
    kind = {"f": "f4", "i": "i4", "u": "u4", "b": "u4"}.get(a.dtype.kind)
    assert kind, f"input {name}: {a.dtype} has no GLSL counterpart"
    a = a.astype(kind)
    if a.ndim == 0:
        a = a.reshape(1, 1)
    elif a.ndim == 1:
        a = a.reshape(-1, 1) if isinstance(value, np.ndarray) else a.reshape(1, -1)
    assert a.ndim == 2 and 1 <= a.shape[1] <= 4, f"input {name}: shape {a.shape}, expected (N,) or (N, 1..4)"
    return np.ascontiguousarray(a)


def _load(name: str, a: NDArray[Any], offset: int, step: int) -> str:
    k = a.shape[1]
    word = {"f": "uintBitsToFloat({})", "i": "int({})", "u": "{}"}[a.dtype.kind]
    parts: Sequence[str] = [word.format(f"pf_in[{offset}u + index * {step}u + {j}u]") for j in range(k)]
    scalar, prefix = {"f": ("float", ""), "i": ("int", "i"), "u": ("uint", "u")}[a.dtype.kind]
    glsl = scalar if k == 1 else f"{prefix}vec{k}"
    return f"{glsl} {name} = {glsl}({', '.join(parts)});"


def _output_kind(spec: Any) -> tuple[str, str, int]:
    """(GLSL type, base letter, components)."""
    if isinstance(spec, str):
        vector = re.fullmatch(r"([iu]?)vec([234])", spec)
        if vector:
            return spec, vector[1] or "f", int(vector[2])
        scalars = {"float": "f", "int": "i", "uint": "u"}
        assert spec in scalars, f"output type {spec!r}: expected float, int, uint or a vector of them"
        return spec, scalars[spec], 1
    components, dtype = spec if isinstance(spec, tuple) else (1, spec)
    if isinstance(components, tuple):
        components = components[-1] if components else 1
    base = np.dtype(dtype).kind
    scalar, prefix = {"f": ("float", ""), "i": ("int", "i"), "u": ("uint", "u")}[base]
    return (scalar if components == 1 else f"{prefix}vec{components}"), base, int(components)
