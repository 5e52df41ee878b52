"""The headless host: what it says when there is no EGL or the driver is too old."""

from __future__ import annotations

import os
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

import planetfall as pf
from planetfall.engine.gpu import FormatError, GLLimitError, GLVersionError, Gpu
from planetfall.engine.gpu.gl import (
    GL,
    MAX_3D_TEXTURE_SIZE,
    MAX_ARRAY_TEXTURE_LAYERS,
    MAX_SHADER_STORAGE_BLOCK_SIZE,
)
from planetfall.engine.gpu.limits import LIMITS
from planetfall.engine.hosts.headless import NoEGLError, create_headless


def test_no_egl_says_what_to_install(monkeypatch):
    monkeypatch.setenv("GLCONTEXT_LINUX_LIBEGL", "libNoSuchEGL.so.9")
    with pytest.raises(NoEGLError, match="apt-get install libegl1 libgl1") as caught:
        create_headless()
    assert "libNoSuchEGL.so.9" in str(caught.value)


def test_an_old_driver_is_named():
    code = (
        "from planetfall.engine.hosts.headless import create_headless\n"
        "try: create_headless()\n"
        "except Exception as e: print(type(e).__name__, e)\n"
    )
    env = {**os.environ, "MESA_GL_VERSION_OVERRIDE": "4.1", "MESA_GLSL_VERSION_OVERRIDE": "410"}
    done = subprocess.run([sys.executable, "-c", code], env=env, capture_output=True, text=True, check=True)
    assert done.stdout.startswith("GLVersionError OpenGL 4.3 core is needed, found 4.1 (version '4.1")
    assert "renderer 'llvmpipe" in done.stdout and "vendor 'Mesa" in done.stdout


def test_gpu_refuses_an_old_context():
    info = {"GL_VERSION": "4.1 INTEL-20", "GL_RENDERER": "Intel Iris", "GL_VENDOR": "Intel Inc."}
    with pytest.raises(GLVersionError, match=r"found 4\.1 .*'Intel Iris'.*'Intel Inc\.'") as caught:
        Gpu(SimpleNamespace(version_code=410, info=info), [])  # type: ignore[arg-type]
    assert (caught.value.required, caught.value.found) == (430, 410)


def test_gpu_refuses_a_driver_with_nothing_but_what_is_promised(gpu, monkeypatch):
    """Storage buffers in vertex shaders, which ground and sea read theirs from, are none of it."""
    promised = {limit.code: limit.promised for limit in LIMITS}
    ask = GL.integer
    monkeypatch.setattr(GL, "integer", lambda self, name: promised.get(name, ask(self, name)))
    with pytest.raises(GLLimitError, match=r"storage buffers that a vertex shader reads: needed 4, found 0") as caught:
        Gpu(gpu.ctx, [])
    assert len(caught.value.missing) == 1 and "Update the graphics driver" in str(caught.value)


def test_with_that_one_more_the_least_driver_draws(monkeypatch):
    least = {limit.code: max(limit.promised, limit.needed) for limit in LIMITS}
    least |= {MAX_3D_TEXTURE_SIZE: 2048, MAX_ARRAY_TEXTURE_LAYERS: 2048, MAX_SHADER_STORAGE_BLOCK_SIZE: 1 << 27}
    ask = GL.integer
    with pf.Renderer(pf.load_scene("earth"), (96, 54), "high") as renderer:
        expected = renderer.render(pf.view("coast"))["color"]
    monkeypatch.setattr(GL, "integer", lambda self, name: least.get(name, ask(self, name)))
    with pf.Renderer(pf.load_scene("earth"), (96, 54), "high") as renderer:
        caps = renderer.gpu.caps
        assert (caps.max_uniform_block_bytes, caps.max_texture_units, caps.max_texture_layers) == (16384, 96, 2048)
        np.testing.assert_array_equal(renderer.render(pf.view("coast"))["color"], expected)


def test_a_buffer_beyond_the_limit_is_refused(gpu):
    with pytest.raises(FormatError, match=r"a buffer of \d+ bytes for 'test' is beyond this GPU's limit of \d+"):
        gpu.scope("test").buffer(reserve=gpu.caps.max_storage_block_bytes + 1)


def test_capabilities(gpu):
    caps = gpu.caps
    assert caps.version_code >= 430 and caps.max_texture_size >= 16384 and caps.max_texture_units >= 48
    assert caps.renderer and caps.vendor and caps.version
