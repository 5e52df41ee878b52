"""Mesa's zink on a software Vulkan keeps uniforms out of its shaders."""

import logging
import os

import pytest

from planetfall.engine.gpu.stale_uniforms import SWITCH, keep_uniforms, warn_of_stale_uniforms

SOFTWARE = "zink Vulkan 1.4(llvmpipe (LLVM 19.1.7, 256 bits) (MESA_LLVMPIPE))"


def test_the_environment_has_the_last_word(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(SWITCH, raising=False)
    keep_uniforms()
    assert os.environ[SWITCH] == "0"
    monkeypatch.setenv(SWITCH, "1")
    keep_uniforms()
    assert os.environ[SWITCH] == "1"


@pytest.mark.parametrize(
    ("renderer", "value", "warned"),
    [
        (SOFTWARE, "1", True),
        (SOFTWARE, "0", False),
        ("zink Vulkan 1.3(NVIDIA GeForce RTX 3080 (NVIDIA_PROPRIETARY))", "1", False),
        ("llvmpipe (LLVM 15.0.6, 256 bits)", "1", False),
    ],
)
def test_a_hosts_context_is_warned_of(
    renderer: str, value: str, warned: bool, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setenv(SWITCH, value)
    with caplog.at_level(logging.WARNING):
        warn_of_stale_uniforms(renderer)
    assert (f"set {SWITCH}=0" in caplog.text) == warned
