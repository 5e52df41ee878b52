"""The headless host: what it says when there is no EGL or the driver is too old."""

from __future__ import annotations

import os
import subprocess
import sys
from types import SimpleNamespace

import pytest

from planetfall.engine.gpu import GLVersionError, Gpu
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


def test_capabilities(gpu):
    caps = gpu.caps
    assert caps.version_code >= 430 and caps.max_texture_size >= 16384 and caps.max_texture_units >= 48
    assert caps.renderer and caps.vendor and caps.version
