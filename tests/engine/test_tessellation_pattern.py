"""The paper mode cuts patches in compute shaders; the vertices are those of OpenGL's own tessellation stage."""

from __future__ import annotations

import moderngl
import numpy as np
import pytest

from planetfall.engine.surface.projected_grid import MOST_LEVEL, Tessellation

pytestmark = pytest.mark.gpu

VERTEX = """#version 410
void main() { gl_Position = vec4(0.0); }
"""
CONTROL = """#version 410
layout(vertices = 4) out;
uniform float u_inner;
uniform vec4 u_outer;   // edges u = 0, v = 0, u = 1, v = 1
void main() {
    gl_TessLevelInner[0] = gl_TessLevelInner[1] = u_inner;
    gl_TessLevelOuter[0] = u_outer.x;
    gl_TessLevelOuter[1] = u_outer.y;
    gl_TessLevelOuter[2] = u_outer.z;
    gl_TessLevelOuter[3] = u_outer.w;
}
"""
EVALUATION = """#version 430
layout(quads, equal_spacing, ccw) in;
layout(std430, binding = 0) buffer PlaceBuffer { uint count; uint pad; vec2 places[]; };
void main() {
    places[atomicAdd(count, 1u)] = gl_TessCoord.xy;   // a vertex may be evaluated more than once
    gl_Position = vec4(gl_TessCoord.xy, 0.0, 1.0);
}
"""
FRAGMENT = """#version 410
layout(location = 0) out vec4 o_color;
void main() { o_color = vec4(1.0); }
"""


def by_gl(gpu, level, edges):
    """Places (N, 2) of all vertices of one patch in 64ths, sorted; edges: levels at u = 0, u = 1, v = 0, v = 1."""
    ctx = gpu.ctx
    program = ctx.program(
        vertex_shader=VERTEX, tess_control_shader=CONTROL, tess_evaluation_shader=EVALUATION, fragment_shader=FRAGMENT
    )
    program["u_inner"] = float(1 << level)
    program["u_outer"] = tuple(float(1 << edges[k]) for k in (0, 2, 1, 3))
    array, target = ctx.vertex_array(program, []), ctx.simple_framebuffer((4, 4))
    buffer = ctx.buffer(bytes(8 + 8 * 6 * 4**MOST_LEVEL))
    query = ctx.query(primitives=True)
    ctx.patch_vertices = 4
    target.use()
    buffer.bind_to_storage_buffer(0)
    with query:
        array.render(moderngl.PATCHES, 4)
    ctx.finish()
    data = buffer.read()
    count = int(np.frombuffer(data, "u4", 1)[0])
    found = np.frombuffer(data, "f4", 2 * count, 8).reshape(-1, 2)
    gpu.leave(target)
    for made in (array, program, buffer, target):
        made.release()
    return np.unique(np.round(found.astype(np.float64) * 64.0, 3), axis=0), query.primitives


def ours(level, edges):
    cut = Tessellation(
        i=np.zeros(1, np.int64), j=np.zeros(1, np.int64), level=np.array([level]), edge_level=np.array([edges]),
        first=np.zeros(1, np.int64), vertices=((1 << level) + 1) ** 2, triangles=2 * 4**level, coarser=1.0,
    )  # fmt: skip
    faces = cut.faces()
    j, i = np.divmod(np.unique(faces), (1 << level) + 1)
    return np.stack([i, j], axis=1) * (64.0 / (1 << level)), faces


@pytest.mark.parametrize(
    ("level", "edges"),
    [(0, (0, 0, 0, 0)), (1, (1, 1, 1, 1)), (3, (3, 3, 3, 3)), (3, (0, 2, 3, 1)), (5, (5, 1, 0, 5)), (6, (6, 5, 6, 3))],
)
def test_vertices_are_those_of_gls_tessellation(gpu, level, edges):
    expected, primitives = by_gl(gpu, level, edges)
    places, faces = ours(level, edges)
    assert np.array_equal(np.unique(places, axis=0), expected)
    # The same number of triangles too: every vertex inside adds two, every one on the border adds one.
    assert len(faces) == primitives
    corner = np.stack(np.divmod(faces, (1 << level) + 1)[::-1], axis=-1)
    u, v = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    assert (area > 0).all() and area.sum() == 2 * 4**level, "counter-clockwise, without gaps"
    assert gpu.ctx.error == "GL_NO_ERROR"
