"""What the driver has to know of each program: every number in an array of structs is a uniform of its own there, and
thousands of them take a tenth of a second and megabytes in each program."""

from __future__ import annotations

import pytest

import planetfall as pf

ACTIVE_UNIFORMS = 0x8B86
MOST = 1000
"""terrain/shade.comp has 820, in some 5 ms and half a megabyte."""


@pytest.mark.gpu
@pytest.mark.parametrize("view", ["near", "orbit"])
def test_no_program_has_thousands_of_uniforms(view: str) -> None:
    with pf.load_scene("earth") as scene, pf.Renderer(scene, (64, 36), "low") as renderer:
        renderer.render(pf.view(view, scene.planet))
        programs = [linked for linked in renderer.gpu.shaders.programs if linked.is_linked]
        found = {
            "+".join(linked.files.values()): renderer.gpu.gl.program_integers(linked.mgl.glo, ACTIVE_UNIFORMS)[0]
            for linked in programs
        }
    assert len(found) > 20
    assert {name: many for name, many in found.items() if many > MOST} == {}


@pytest.mark.gpu
def test_a_picture_links_what_it_needs_alone() -> None:
    """Dozens of the programs that a scene may need are never used by a picture of it."""
    with pf.load_scene("earth") as scene, pf.Renderer(scene, (64, 36), "low") as renderer:
        renderer.render(pf.view("near", scene.planet))
        linked = [each.is_linked for each in renderer.gpu.shaders.programs]
    assert linked.count(False) >= 20
