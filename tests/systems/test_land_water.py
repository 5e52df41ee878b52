"""Rivers and lakes in pictures: where they are drawn, how they lie, what they cost a scene that has none."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray
from river_kit import with_rivers

import planetfall as pf
from planetfall.systems.terrain.height import TerrainParams, height
from planetfall.systems.terrain.rivers.nodes import RiverNodes
from planetfall.systems.terrain.rivers.table import RiverTable
from planetfall.systems.terrain.rivers.valleys import waters

pytestmark = pytest.mark.gpu

Floats = NDArray[np.float64]
SIZE = (320, 180)
TERRAIN, SEA, COVER = 1, 2, 4
SEED = 7
"""Of the ground that is given rivers; others keep none."""
NOON = {"elevation_deg": 50.0}


class Carved(NamedTuple):
    renderer: pf.Renderer
    params: TerrainParams
    table: RiverTable
    nodes: RiverNodes


class Seen(NamedTuple):
    """A picture's outputs, and per pixel the twin's water where the drawn point is. footprint_m: of a pixel on level
    ground, its longer side."""

    picture: dict[str, NDArray[np.generic]]
    points_m: Floats
    shown: NDArray[np.bool_]
    beyond_m: Floats
    level_m: Floats
    altitude_m: Floats
    footprint_m: Floats


@pytest.fixture(scope="module")
def carved() -> Iterator[Carved]:
    """Earth with a few rivers."""
    known: dict[str, tuple[TerrainParams, RiverNodes]] = {}
    plain = TerrainParams.from_component

    def with_some(*args, **named):
        params = plain(*args, **named)
        if params.seed != SEED:
            return params
        key = repr(params)
        if key not in known:
            known[key] = with_rivers(params)
        return known[key][0]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(TerrainParams, "from_component", staticmethod(with_some))
        with pf.load_scene("earth") as scene:
            planet = scene.planet
            planet[pf.Terrain].seed, planet[pf.Terrain].rivers = SEED, 0.0
            params = TerrainParams.from_component(planet[pf.Terrain], planet[pf.Planet].radius_m)
            nodes = next(nodes for ground, nodes in known.values() if ground is params)
            assert params.rivers is not None
            with pf.Renderer(scene, SIZE, "medium") as renderer:
                yield Carved(renderer, params, params.rivers, nodes)


def middle_of_water(carved: Carved, direction: Floats) -> Floats:
    """Unit direction of the place within 2.5 km that is furthest from the edge of its water."""
    radius_m = carved.params.radius_m
    east = np.cross([0.0, 0.0, 1.0], direction)
    east /= np.linalg.norm(east)
    north = np.cross(direction, east)
    along = np.linspace(-2500.0, 2500.0, 151)
    x, y = (grid.ravel() for grid in np.meshgrid(along, along))
    places = direction[:, None] * radius_m + east[:, None] * x + north[:, None] * y
    places *= radius_m / np.linalg.norm(places, axis=0)
    return places[:, np.argmin(waters(carved.table, places).beyond_m)] / radius_m


def look(carved: Carved, place: Floats, altitude_m: float, pitch_deg: float, heading_deg: float, **sun: float) -> Seen:
    latitude, longitude = np.degrees(np.arcsin(place[2])), np.degrees(np.arctan2(place[1], place[0]))
    camera = pf.Camera.at(latitude, longitude, altitude_m, heading_deg=heading_deg, pitch_deg=pitch_deg)
    light = pf.Sun(latitude_deg=latitude, longitude_deg=longitude, **sun)
    carved.renderer.settle(camera, sun=light)
    names = ("surface", "position", "normal", "radiance", "distance", "terrain.land_water")
    picture = carved.renderer.render(camera, sun=light, outputs=names)
    state = carved.renderer.camera_state(camera)
    seen = picture["position"].astype(np.float64).reshape(-1, 3)
    shown = np.isfinite(seen).all(axis=1)
    points = np.where(shown[:, None], seen, 0.0) + state.position_m
    length = np.linalg.norm(points, axis=1)
    up = points / length[:, None]
    found = waters(carved.table, up.T * carved.params.radius_m)
    distance = np.where(shown, np.linalg.norm(np.where(shown[:, None], seen, 0.0), axis=1), 1.0)
    sine = np.maximum(-(np.where(shown[:, None], seen, -up) * up).sum(axis=1) / distance, 0.01)
    footprint = distance * (2.0 * np.tan(np.radians(30.0)) / SIZE[1]) / sine
    return Seen(picture, points, shown, found.beyond_m, found.level_m, length - carved.params.radius_m, footprint)


@pytest.fixture(scope="module")
def river(carved: Carved) -> tuple[Floats, float, float]:
    """A place in a river above the sea: direction, level, heading downstream."""
    nodes = carved.nodes
    start = next(k for k in range(len(nodes)) if nodes.level_m[k] > 200.0 and not nodes.lake[nodes.to[k]])
    here, there = nodes.direction[start], nodes.direction[nodes.to[start]]
    place = middle_of_water(carved, here + 0.4 * (there - here))
    east = np.cross([0.0, 0.0, 1.0], place)
    way = there - here
    heading = np.degrees(np.arctan2(way @ east / np.linalg.norm(east), way @ np.cross(place, east)))
    level = waters(carved.table, place[:, None] * carved.params.radius_m).level_m[0]
    return place, float(level), float(heading)


@pytest.fixture(scope="module")
def lake(carved: Carved) -> tuple[Floats, float]:
    """The middle of a lake above the sea, and its level."""
    nodes = carved.nodes
    wet = [k for k in range(len(nodes)) if nodes.lake[k] and nodes.to[k] >= 0 and nodes.level_m[k] > 100.0]
    middle = nodes.direction[wet[0]] + nodes.direction[nodes.to[wet[0]]]
    return middle / np.linalg.norm(middle), float(nodes.level_m[wet[0]])


@pytest.mark.parametrize(("above_m", "pitch_deg"), [(300.0, -35.0), (1500.0, -50.0)])
def test_pixels_of_water_are_where_the_lines_say(carved: Carved, river, above_m: float, pitch_deg: float) -> None:
    place, level_m, heading_deg = river
    seen = look(carved, place, level_m + above_m, pitch_deg, heading_deg - 40.0, **NOON)
    surface = seen.picture["surface"].ravel()
    directions = seen.points_m / np.linalg.norm(seen.points_m, axis=1)[:, None]
    ground_m = height(directions, carved.params)
    expected = (seen.beyond_m < 0.0) & (seen.level_m > ground_m)
    # The pixels' own width, and what the mesh is off by, move an edge.
    clear = seen.shown & (np.abs(seen.beyond_m) > 2.0 * seen.footprint_m) & (seen.footprint_m < 20.0)
    clear &= (ground_m > 0.0) | expected
    water = surface == SEA
    assert min(expected[clear].mean(), 1.0 - expected[clear].mean()) > 0.02
    assert (water == expected)[clear].mean() >= 0.995
    # Plants on its banks may hide a few pixels.
    assert set(np.unique(surface[seen.shown])) <= {TERRAIN, SEA, COVER}
    plants = surface == COVER
    assert plants[seen.shown].mean() < 0.01
    off_m = np.abs(seen.altitude_m - seen.level_m)[water & clear]
    assert (off_m <= np.maximum(1e-3, 1e-3 * seen.footprint_m[water & clear])).all()


@pytest.mark.parametrize("turn_deg", [8.0, 172.0])
def test_flat_lines_of_sight_meet_the_slope_of_a_river(carved: Carved, river, turn_deg: float) -> None:
    """Down and up the river, which falls by metres within what is seen of it."""
    place, level_m, heading_deg = river
    seen = look(carved, place, level_m + 6.0, -3.0, heading_deg + turn_deg, **NOON)
    water = (seen.picture["surface"].ravel() == SEA) & (seen.beyond_m < 0.0)
    distance = seen.picture["distance"].ravel()
    water &= distance < 1500.0
    assert water.mean() > 0.1
    assert np.ptp(seen.level_m[water]) > 0.1
    off_m = np.abs(seen.altitude_m - seen.level_m)[water]
    # A pixel's height at right angles to the view.
    assert np.quantile(off_m / (distance[water] * 2.0 * np.tan(np.radians(30.0)) / SIZE[1]), 0.99) < 0.25


def test_no_waves_of_the_sea_on_a_lake(carved: Carved, lake) -> None:
    place, level_m = lake
    seen = look(carved, place, level_m + 20.0, -20.0, 40.0, **NOON)
    sea = carved.renderer.scene.planet[pf.Ocean]
    directions = seen.points_m / np.linalg.norm(seen.points_m, axis=1)[:, None]
    water = (seen.picture["surface"].ravel() == SEA) & (seen.beyond_m < 0.0)
    assert water.mean() > 0.3
    normals = seen.picture["normal"].reshape(-1, 3)[water].astype(np.float64)
    tilt = np.linalg.norm(np.cross(normals, directions[water]), axis=1)
    # The G-buffer keeps normals in steps of 3e-5.
    assert tilt.max() < 1e-3
    # And where there is sea, there are waves.
    assert sea.wind_speed_m_s > 0.0
    open_sea = carved.renderer.render(pf.view("coast", "earth"), 416880.0, outputs=("surface", "normal", "position"))
    at_sea = open_sea["surface"] == SEA
    around = open_sea["normal"][at_sea].astype(np.float64)
    assert np.std(around - around.mean(axis=0), axis=0).max() > 1e-2


def test_water_mirrors_the_sky(carved: Carved, lake) -> None:
    """Flat lines of sight see the sky in it, steep ones the water itself."""
    place, level_m = lake
    seen = look(carved, place, level_m + 20.0, -25.0, 200.0, **NOON)
    water = (seen.picture["surface"] == SEA) & (seen.beyond_m.reshape(SIZE[::-1]) < 0.0)
    light = seen.picture["radiance"][..., 1]
    distance = seen.picture["distance"]
    flat, steep = water & (distance > 300.0) & (distance < 2000.0), water & (distance < 40.0)
    assert flat.sum() > 500 and steep.sum() > 500
    # The sun's own mirror image is in neither half of them.
    assert np.median(light[flat]) > 3.0 * np.median(light[steep])


def test_rivers_narrower_than_a_pixel_keep_their_share_of_it(carved: Carved, river) -> None:
    """Over the length of a river what its pixels hold of water adds up to its area."""
    place, _, heading_deg = river
    seen = look(carved, place, 6e4, -89.0, heading_deg, **NOON)
    texels = seen.picture["terrain.land_water"].reshape(*SIZE[::-1], -1)
    shares = np.where(texels[..., 0] == 0, texels[..., 1] & 0xFF, 0) / 255.0
    grid = {name: getattr(seen, name).reshape(SIZE[::-1]) for name in ("beyond_m", "footprint_m")}
    pixel_m = float(np.median(grid["footprint_m"]))
    half_m = float(carved.nodes.half_width_m[0])
    assert half_m < 0.75 * pixel_m  # else it would be a surface of its own
    # Lakes are wide enough to be drawn whole, and lie elsewhere.
    near = grid["beyond_m"] < 3.0 * pixel_m
    rows = near.any(axis=1) & (near.sum(axis=1) < 20)
    assert rows.sum() > 30
    crossed = shares[rows].sum(axis=1)
    # A row crosses it at a slant; what bends lines stretches them by up to half.
    assert np.median(crossed) > 0.8 * 2.0 * half_m / pixel_m
    assert np.median(crossed) < 3.0 * 2.0 * half_m / pixel_m
    assert shares[~near].max() == 0.0


def test_a_narrow_river_is_a_line_where_one_of_four_pixels_is_shaded(carved: Carved, river) -> None:
    """Quality low: in all rows that it crosses it stands out from the ground beside it, not in every other block."""
    place, level_m, heading_deg = river
    with pf.Renderer(carved.renderer.scene, SIZE, "low") as renderer:
        seen = look(carved._replace(renderer=renderer), place, level_m + 1.6e4, -60.0, heading_deg + 10.0, **NOON)
    light = seen.picture["radiance"].sum(axis=2)
    texels = seen.picture["terrain.land_water"].reshape(*SIZE[::-1], -1)
    shares = np.where(texels[..., 0] == 0, texels[..., 1] & 0xFF, 0) / 255.0
    # Only where it is narrow, and one of its lines crosses the row.
    apart = seen.beyond_m.reshape(SIZE[::-1]) / seen.footprint_m.reshape(SIZE[::-1])
    contrasts = []
    for row, share, beyond in zip(light, shares, apart, strict=True):
        middle = int(np.argmax(share))
        inside = slice(max(middle - 12, 0), middle + 13)
        if share[middle] < 0.5 or (beyond[inside] < 1.0).sum() > 6 or not 12 < middle < SIZE[0] - 13:
            continue
        ground = row[inside][beyond[inside] > 2.5]
        contrasts.append((row[middle] - ground.mean()) / (ground.mean() * share[middle]))
    assert len(contrasts) > 40
    typical = float(np.median(contrasts))
    assert abs(typical) > 0.1
    # Of dashes two in five rows had none.
    assert (np.array(contrasts) / typical > 0.4).mean() > 0.95


NAMES = re.compile(r"land_water|LandWater|narrow_water|g_muddy|RiverLine")
FILES = ("ocean/shade.comp", "ocean/surface.comp", "ocean/swell.comp", "ocean/classify.comp", "ocean/light.comp")


def compiled(text: str, unknown: frozenset[str]) -> str:
    """What of a shader's text is left where none of these names is defined."""
    kept: list[str] = []
    open_blocks: list[bool] = []
    for line in re.sub(r"//.*", "", text).splitlines():
        words = line.replace("#", " # ").split()
        directive = words[1] if len(words) > 1 and words[0] == "#" else ""
        if directive in ("if", "ifdef", "ifndef"):
            asked = {name for name in unknown if re.search(rf"\b{name}\b", line)}
            open_blocks.append(not asked or directive == "ifndef")
        elif directive in ("else", "elif") and open_blocks and not open_blocks[-1]:
            open_blocks[-1] = True
        elif directive == "endif":
            open_blocks.pop()
        elif all(open_blocks) and "PF_INCLUDED" not in line:
            kept.append(line)
    return "\n".join(kept)


def test_a_scene_without_rivers_has_nothing_of_them() -> None:
    """No pass, and no line of a shader."""
    with pf.load_scene("earth") as scene:
        scene.planet[pf.Terrain].rivers = 0.0
        with pf.Renderer(scene, (64, 36), "medium") as renderer:
            renderer.render(pf.view("coast", "earth"))
            names = {report.name for report in renderer.passes()}
            assert "terrain.coast" in names
            assert not {name for name in names if "water" in name and name.startswith("terrain")}
            unknown = frozenset({"OCEAN_LAND_WATER", "LAND_WATER", "GROUND_RIVERS", "TERRAIN_RIVERS"})
            for file in (*FILES, "terrain/shade.comp", "terrain/list_wet.comp"):
                text = renderer.gpu.shaders.sources.expand(file, {"OCEAN_RICH": 1}).text
                found = NAMES.search(compiled(text, unknown))
                assert found is None, (file, found)


def test_questions_of_water_agree_with_the_ground(carved: Carved, river, lake) -> None:
    sampler = pf.TerrainSampler(carved.renderer.scene)
    rng = np.random.default_rng(4)
    places = np.concatenate([carved.nodes.direction] * 8)
    places = places + rng.normal(size=places.shape) * (1500.0 / carved.params.radius_m)
    found, ground = sampler.water(places), sampler.height(places)
    wet = ~np.isnan(found.level_m)
    assert 0.1 < wet.mean() < 0.9
    np.testing.assert_allclose(found.depth_m[wet], (found.level_m - ground)[wet], rtol=0.0, atol=1e-9)
    assert (found.depth_m[wet] > 0.0).all()
    assert (found.depth_m[~wet] == 0.0).all()
    assert (found.current_m_s[~wet] == 0.0).all()
    # No ground below the sea's level is dry.
    assert wet[ground < 0.0].all()
    place, level_m, _ = river
    middle = sampler.water(place[None])
    assert middle.level_m[0] == pytest.approx(level_m, abs=1e-6)
    assert 0.1 < np.linalg.norm(middle.current_m_s[0]) < 7.5
    assert middle.current_m_s[0] @ place == pytest.approx(0.0, abs=1e-6 * np.linalg.norm(middle.current_m_s[0]) + 1e-9)
    still = sampler.water(lake[0][None])
    assert still.level_m[0] == pytest.approx(lake[1], abs=1e-3)
    # What flows through: 500 m3/s by a section 6 km wide and 12 m deep in its middle.
    assert 0.005 < np.linalg.norm(still.current_m_s[0]) < 0.016
    bare = pf.TerrainSampler.from_params(TerrainParams()).water(places)
    assert np.isnan(bare.level_m).all()
    with pytest.raises(ValueError, match=r"directions\[1\]: expected a direction, found the zero vector"):
        sampler.water([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])


def test_tiles_of_the_picture_do_not_show():
    """Above a fall, where the river turns from muddy to clear: what is mixed comes from lines that all tiles ask."""
    latitude_deg, longitude_deg = 26.68165, 110.98199
    with pf.load_scene("earth") as scene, pf.Renderer(scene, (320, 180), "low") as renderer:
        camera = pf.Camera.at(latitude_deg, longitude_deg, 330.0, 158.0, -60.0, above="ground")
        sun = pf.Sun(elevation_deg=45.0, azimuth_deg=298.0, latitude_deg=latitude_deg, longitude_deg=longitude_deg)
        picture = renderer.render(camera, sun=sun, outputs=("color", "surface"))
    light, water = picture["color"][:60].astype(float), picture["surface"][:60] == 2
    steps, both = np.abs(np.diff(light, axis=0)).sum(axis=2), water[1:] & water[:-1]
    assert both.sum(axis=1).min() > 20
    assert max(np.median(row[there]) for row, there in zip(steps, both, strict=True)) < 6.0
