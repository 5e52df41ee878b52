"""Reversed depth with clip control, and the same depth values without it (a driver at 4.3 without ARB_clip_control)."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np

from planetfall import ASSETS
from planetfall.engine.gpu import Gpu
from planetfall.engine.hosts.headless import create_headless

NEAR_M = 0.1
SIZE = 64

VERTEX = """
in vec3 in_position;  // ndc x, ndc y, metres along forward
void main() { gl_Position = vec4(in_position.xy * in_position.z, 0.1, in_position.z); }
"""
FRAGMENT = """
layout(location = 0) out uint o_id;
uniform int u_id;
void main() {
    o_id = uint(u_id);
#ifdef PF_FRAG_DEPTH
    gl_FragDepth = 0.1 * gl_FragCoord.w;
#endif
}
"""


def draw(gpu: Gpu) -> tuple[np.ndarray, np.ndarray]:
    """Strips at 0.11 m to 1e8 m, slightly slanted, each twice: 2e-6 apart, the nearer one first or last."""
    scope = gpu.scope("depth")
    gpu.shaders.add_virtual("test/depth.vert", VERTEX)
    gpu.shaders.add_virtual("test/depth.frag", FRAGMENT)
    program = scope.program("test/depth.vert", "test/depth.frag")
    ids = scope.texture((SIZE, SIZE), "r8ui")
    depth = scope.texture((SIZE, SIZE), "depth32f")
    target = scope.framebuffer([ids], depth)
    with gpu.frame():
        target.clear(depth=0.0)
        target.use()
        gpu.state(depth_test=True, depth_func=">=").apply()
        distances = np.geomspace(0.11, 1e8, 16)
        for k, z in enumerate(distances):
            x0, x1 = -1 + 2 * k / 16, -1 + 2 * (k + 1) / 16
            for identity in (1, 2) if k % 2 else (2, 1):
                far = z * (1 + 2e-6 * (identity == 1))
                quad = [(x0, -0.9, far), (x1, -0.9, far), (x0, 0.9, far * 1.01), (x1, 0.9, far * 1.01)]
                strip = scope.vertex_array(program, [(scope.buffer(np.array(quad, "f4")), "3f", "in_position")])
                program.set("u_id", identity)
                strip.render(5)  # triangle strip
    result = np.frombuffer(depth.read(), "f4").reshape(SIZE, SIZE), np.frombuffer(ids.read(), "u1").reshape(SIZE, SIZE)
    scope.release()
    assert gpu.ctx.error == "GL_NO_ERROR"
    return result


def test_depth_is_near_over_z_and_sorts_to_two_parts_in_a_million(gpu):
    depth, ids = draw(gpu)
    rows = slice(4, SIZE - 4)
    assert (ids[rows] == 2).all()
    assert (depth[0] == 0).all()  # nothing drawn there
    # At the strip's middle, 1/z is halfway between 1/z and 1/(1.01 z).
    expected = NEAR_M / np.geomspace(0.11, 1e8, 16) * (1 + 1 / 1.01) / 2
    middle = depth[SIZE // 2 - 1 : SIZE // 2 + 1, 2::4].astype(float).mean(axis=0)
    np.testing.assert_allclose(middle, expected, rtol=3e-7)


def test_without_clip_control_shaders_write_the_same_depth(gpu, tmp_path):
    env = {
        **os.environ,
        "MESA_GL_VERSION_OVERRIDE": "4.3",
        "MESA_GLSL_VERSION_OVERRIDE": "430",
        "MESA_EXTENSION_OVERRIDE": "-GL_ARB_clip_control",
    }
    file = tmp_path / "depth.npz"
    subprocess.run([sys.executable, __file__, str(file)], env=env, check=True, capture_output=True, text=True)
    there = np.load(file)
    assert not there["has_clip_control"] and there["version"] == 430
    depth, ids = draw(gpu)
    np.testing.assert_array_equal(there["ids"], ids)
    np.testing.assert_allclose(there["depth"], depth, rtol=5e-7)


if __name__ == "__main__":
    bare = Gpu(create_headless(), [ASSETS / "shaders"])
    found_depth, found_ids = draw(bare)
    np.savez(
        sys.argv[1],
        depth=found_depth,
        ids=found_ids,
        has_clip_control=bare.caps.has_clip_control,
        version=bare.caps.version_code,
    )
