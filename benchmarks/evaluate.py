"""Evaluate GLSL on arrays: a shader function of the library against its float64 reference."""

from __future__ import annotations

import ctypes
import itertools
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..engine.gpu import Gpu

_TYPES = {"float": ("f", 1), "vec2": ("f", 2), "vec3": ("f", 3), "vec4": ("f", 4), "int": ("i", 1), "ivec2": ("i", 2),
          "ivec3": ("i", 3), "ivec4": ("i", 4), "uint": ("u", 1)}  # fmt: skip
_WORD = {"f": "uintBitsToFloat({})", "i": "int({})", "u": "{}"}
_STORE = {"f": "floatBitsToUint({})", "i": "uint({})", "u": "{}"}
_NUMPY: dict[str, Any] = {"f": np.float32, "i": np.int32, "u": np.uint32}
_INPUT, _OUTPUT = 6, 7
_serial = itertools.count()

Values = dict[str, NDArray[Any]]


class Evaluator:
    """A compute program that evaluates statements for each element of arrays.

    body: GLSL statements; inputs and outputs (name -> float, vec2, vec3, vec4, int, ivec2, ..., uint) stand there as
    variables. header: what stands before main, such as #include lines; storage points 6 and 7 are taken. Compiled once;
    call it with arrays (N,) or (N, components) by name. before: called before each dispatch, to bind buffers.
    """

    def __init__(
        self,
        gpu: Gpu,
        body: str,
        inputs: Mapping[str, str],
        outputs: Mapping[str, str],
        header: str = "",
        defines: Mapping[str, Any] | None = None,
    ) -> None:
        self.inputs, self.outputs = dict(inputs), dict(outputs)
        self._gpu = gpu
        self._use_program = gpu.gl.function("glUseProgram", None, ctypes.c_uint)
        self._scope = gpu.scope("evaluator")
        loads, stores = [], []
        stride = 0
        for name, glsl in inputs.items():
            base, k = _TYPES[glsl]
            words = ", ".join(_WORD[base].format(f"pf_in[at + {stride + j}u]") for j in range(k))
            loads.append(f"{glsl} {name} = {glsl}({words});")
            stride += k
        self._stride = stride
        at = 0
        for name, glsl in outputs.items():
            base, k = _TYPES[glsl]
            loads.append(f"{glsl} {name} = {glsl}(0);")
            for j in range(k):
                part = name if k == 1 else f"{name}[{j}]"
                stores.append(f"pf_out[index * {{words}}u + {at + j}u] = {_STORE[base].format(part)};")
            at += k
        self._words = at
        newline = "\n    "
        text = f"""
{header}
layout(local_size_x = 64) in;
layout(std430, binding = {_INPUT}) readonly buffer PfInputs {{ uint pf_in[]; }};
layout(std430, binding = {_OUTPUT}) writeonly buffer PfOutputs {{ uint pf_out[]; }};
uniform uint u_count;
void main() {{
    uint index = gl_GlobalInvocationID.x;
    if (index >= u_count) return;
    uint at = index * {stride}u;
    {newline.join(loads)}
    {{
{body}
    }}
    {newline.join(line.format(words=at) for line in stores)}
}}
"""
        name = f"generated/evaluate_{next(_serial)}.comp"
        gpu.shaders.add_virtual(name, text)
        self._compute = self._scope.compute(name, dict(defines or {}))

    def __call__(self, before: Callable[[], object] | None = None, **arrays: ArrayLike) -> Values:
        if arrays.keys() != self.inputs.keys():
            raise ValueError(f"Evaluator: expected inputs {', '.join(self.inputs)}, found {', '.join(arrays)}")
        columns = []
        for name, glsl in self.inputs.items():
            base, k = _TYPES[glsl]
            column = np.ascontiguousarray(np.asarray(arrays[name]).astype(_NUMPY[base])).reshape(-1, k)
            columns.append(column.view(np.uint32))
        packed = np.ascontiguousarray(np.concatenate(columns, axis=1))
        count = len(packed)
        source = self._scope.buffer(packed)
        target = self._scope.buffer(reserve=max(4 * count * self._words, 4))
        try:
            if before is not None:
                before()
            source.bind_to_storage_buffer(_INPUT)
            target.bind_to_storage_buffer(_OUTPUT)
            self._compute.set("u_count", count)
            self._compute.run((count + 63) // 64)
            self._gpu.barrier()
            words = np.frombuffer(target.read(), np.uint32)[: count * self._words].reshape(count, self._words)
        finally:
            self._scope.free(source)
            self._scope.free(target)
        results: Values = {}
        at = 0
        for name, glsl in self.outputs.items():
            base, k = _TYPES[glsl]
            part = np.ascontiguousarray(words[:, at : at + k]).view(_NUMPY[base])
            results[name] = part[:, 0] if k == 1 else part
            at += k
        return results

    def release(self) -> None:
        """Free the program."""
        self._use_program(0)  # a guard of the host's state would try to put back a program that is gone
        self._scope.release()

    def __enter__(self) -> Evaluator:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()
