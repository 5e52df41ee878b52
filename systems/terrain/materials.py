"""What the ground is made of, as a list: a material's colour, where it lies, and what is on it.

A new material is one entry of `MATERIALS` (or, a game's own, one call of `planetfall.extend.register_material`): the
shader, the uniform block and the table of docs/materials.md are made from the list. Rules and colours are GLSL: an
expression, or statements that return one. Numbers in them without a source are chosen by eye, against photographs.

Words that they may use: those of `INPUTS`; `NAME_share` and `NAME_color` of another material; albedos by the names of
Terrain's fields, and `NAME_albedo` of a material that has its own; GLSL's functions, and of
assets/shaders/terrain/ground_at.glsl ramp(from, to, x), which goes from 0 to 1, and bell(x, center, 1 / width).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

__all__ = ["INPUTS", "MATERIALS", "Material", "Ripples"]


@dataclass(frozen=True)
class Ripples:
    """What the wind makes of loose ground: bent waves.

    wavelength_m: 0.036 m times a power of two is taken. bend: how far crests wander, in wavelengths. slope: of the
    steepest places. tint: how much lighter crests are, as a share. share: GLSL, where they show; "" is where the
    material does.
    """

    wavelength_m: float
    bend: float
    slope: float
    tint: float
    share: str = ""


@dataclass(frozen=True)
class Material:
    """One material, or a mixture of those that name it in `within`.

    rule: GLSL, the share of ground that it covers, 0..1; "" is the first one of a mixture, which covers all. Within a
    mixture later ones lie over earlier ones. albedo: share of light that it throws back, linear sRGB; or the name of
    another's or of a field of Terrain; or shares of such; () is a mixture. color: GLSL, of which `albedo` is what that
    says or the mixture's colour. roughness: height of its bumps, where soil has 1 (Terrain.grain scales all); None:
    those of what lies below. All ground is matt: Terrain.dust_law says how. bumps_before: the material that its own
    bumps are laid before, as its rule leaves that one out. buries: share of the bumps below that it hides. stones,
    plants: share of the things on it that stand on soil; None: as on what lies below. at_foot: that share is counted
    where a thing has its foot (terrain/clutter.glsl). hides_trees: that share counts for trees as well.
    """

    name: str
    about: str
    within: str = ""
    rule: str = ""
    albedo: str | tuple[float, ...] | Mapping[str, float] = ()
    color: str = "albedo"
    roughness: float | None = None
    bumps_before: str = ""
    buries: float = 0.0
    ripples: Ripples | None = None
    stones: float | None = None
    plants: float | None = None
    at_foot: bool = False
    hides_trees: bool = True


INPUTS: dict[str, str] = {
    "height_m": "height above the reference sphere, m",
    "above_sea_m": "height above the sea, m; 1e9 and more on worlds without one",
    "slope": "rise in metres per metre; relief that the pixel hides counts with its rms slope",
    "hidden_slope": "rms slope of that relief alone",
    "footprint_m": "what the pixel covers on the ground, m",
    "roughness": "steepness of the relief around, 1 as on Earth's land; it rises in mountain ranges",
    "moisture": "of the ground by itself, 0..1; patches of a thousand kilometres",
    "latitude_sine": "0 at the equator, 1 at the poles",
    "mean_warmth": "0 at the snow line, 1 at the equator's sea; falls with height and towards the poles",
    "warmth": "the same with some chance",
    "warmth_per_m": "by how much it falls with each metre of height",
    "winter": "how far it is winter, 0..1 (Terrain.season); 0 in the tropics",
    "sunny": "-1: as steep a slope to the pole as there is any, 1: to the equator; 0 in the tropics",
    "mean_humidity": "moisture in its climate: 0.3 is desert, 0.7 forest",
    "humidity": "the same with some chance",
    "wooded": "where woods may stand, 0..1: a map's forests (Terrain.vector_map), 1 without one and beyond it",
    "green": "share that plants may cover, 0..1: wet enough, and Terrain.plants allows it",
    "rooted": "how firmly roots hold soil on slopes, 0..1",
    "plants": "Terrain.plants",
    "sanded": "where loose sand gathers, 0..1: in dry hollows of the noise",
    "steep": "-1: soil all over, 1: too steep for any; in between both, by chance",
    "barred": "share of gravel and silt that a river or lake has laid along its bank, 0..1",
    "silted": "how much of that is silt, 0..1",
    "layered": "height in the layers of rock, about -1..1; 0 where pixels span them",
    "fine": "noise of 3 to 20 footprints, variance about 1",
    "broad": "noise of about 40 footprints, variance about 1",
    "region": "noise of a kilometre, variance about 1",
    "grain": "fine times Terrain.variation, less from far away",
    "patches": "broad times the same",
    "mixed": "0.7 patches and 0.5 grain",
    "stones": "peaks of the fine noise, 0..1; none where a pixel is wider than 120 m",
    "tufts": "hollows of the fine noise, 0..1; likewise",
    "beach_height_m": "Terrain.beach_height_m, less where the coast has no beach (Terrain.beach_share)",
    "snow_slope": "Terrain.snow_slope_deg as rise in metres per metre",
}
"""What a rule may know of a place, all floats: the struct Ground of terrain/ground_at.glsl, which fills it."""

MATERIALS: tuple[Material, ...] = (
    Material("ground", "all of it"),
    Material("bare", "what snow lies on", "ground", color="albedo * (1.0 + 0.12 * patches + 0.08 * grain)"),
    Material("soil", "level ground without plants", "bare"),
    Material("dry_soil", "desert, dust", "soil", albedo="dry_albedo"),
    Material("dunes", "loose sand in dry hollows", "soil", "0.8 * sanded", "sand_albedo",
        ripples=Ripples(0.07, 0.4, 0.22, 0.08,
            "sanded * (1.0 - plants_share) * (1.0 - rock_share) * (1.0 - snow_share)")),
    Material("dark_plains", "worlds without plants, as the maria of the moon", "soil",
        "0.9 * (1.0 - plants) * ramp(0.50, 0.64, moisture + 0.06 * mixed)", "sand_albedo"),
    # Half of it is the soil between the stones.
    Material("gravel", "patches, most in rough relief", "soil",
        "0.65 * ramp(0.7, 1.9, 1.2 * patches - mixed + 2.0 * roughness)",
        {"dry_albedo": 0.5, "strata_albedo": 0.25, "rock_albedo": 0.25}),
    Material("moist_soil", "wet soil is darker", "soil",
        "ramp(0.15, 0.5, humidity) * plants", "dry_albedo", "albedo * vec3(0.40, 0.42, 0.46)"),
    Material("stones", "peaks of the fine noise", "soil", "stones * 0.6", "rock_albedo", "albedo * 1.1"),
    Material("tufts", "its hollows, where it isn't desert", "soil",
        "tufts * 0.7 * plants * ramp(0.1, 0.33, humidity)", "hay_albedo", "albedo * 0.5"),
    Material("plants", "green and wet enough", "bare",
        "green * ramp(-1.6, -0.3, grain + 2.0 * green - 1.0)", color="albedo * (1.0 + 0.24 * grain - 0.3 * tufts)"),
    Material("tundra", "moss and heath in the cold", "plants",
        albedo="tundra_albedo", color="albedo * (1.0 + 0.25 * mixed)"),
    Material("meadows", "plants of warm places", "plants", "ramp(0.07, 0.25, warmth + 0.015 * grain)"),
    Material("grass", "where they aren't withered", "meadows", albedo="grass_albedo"),
    Material("hay", "dry grass", "meadows",
        "clamp(ramp(0.60, 0.37, humidity) * 0.8 + 0.5 * winter + 0.32 * mixed + 0.1 * grain, 0.0, 1.0)",
        {"grass_albedo": 0.45, "dry_albedo": 0.35}),
    Material("forest", "wet and warm", "meadows",
        "wooded * ramp(0.52, 0.70, humidity + 0.04 * grain) * ramp(0.15, 0.28, warmth)", "forest_albedo"),
    Material("bars", "along rivers and lakes (Terrain.banks): gravel, or silt of muddy ones", "bare", "barred",
        {"rock_albedo": 0.6, "dry_albedo": 0.25, "strata_albedo": 0.25},
        "mix(albedo, 0.55 * sand_albedo, silted) * (1.0 + 0.22 * grain + 0.3 * stones)", plants=0.0),
    Material("scree", "slopes too steep for soil, unless roots hold it", "bare",
        "(0.55 - 0.4 * rooted) * ramp(-1.7, -0.4, steep)", color="0.75 * rock_color + 0.25 * dry_albedo"),
    Material("rock", "steeper ones", "bare", "smoothstep(-1.0, 1.0, steep)",
        color="albedo * (1.0 + 0.14 * grain - 0.2 * tufts + 0.35 * layered)", roughness=1.8, plants=0.0),
    Material("bedrock", "rock between the strata", "rock", albedo="rock_albedo"),
    Material("strata", "layers of another colour", "rock",
        "clamp(0.4 + 1.6 * layered + 0.15 * patches, 0.0, 1.0)", "strata_albedo"),
    # Both as a share of the pixel where they are narrower than that.
    Material("shingle", "stones that waves have bared along the sea, where there is no sand", "bare", """
        float high_m = 1.5 * (1.0 + 0.5 * clamp(mixed, -1.5, 1.5));
        float rise = max(slope, 0.02) * footprint_m;
        float bared = high_m / (high_m + 0.5 * rise)
            * clamp(3.0 - 3.0 * (above_sea_m - 0.5 * rise) / (high_m + rise), 0.0, 1.0);
        return bared * ramp(2500.0, 250.0, footprint_m);
        """, {"rock_albedo": 0.7, "dry_albedo": 0.3},
        "albedo * (0.75 + 0.2 * grain + 0.3 * stones)", roughness=1.5, stones=1.0, plants=0.0),
    Material("beach", "sand along the sea", "bare", """
        float beach_m = beach_height_m * (1.0 + 0.4 * clamp(mixed, -2.0, 2.0));
        float rise = max(slope, 0.02) * footprint_m;
        float beach = beach_m / (beach_m + 0.5 * rise + 1e-3)
            * clamp(2.5 - 2.5 * (above_sea_m - 0.5 * rise) / (beach_m + rise + 1e-3), 0.0, 1.0);
        return beach * ((1.0 - rock_share) * ramp(2500.0, 250.0, footprint_m));
        """, "sand_albedo", "albedo * (1.0 + 0.07 * grain + 0.07 * stones)",
        roughness=0.4, bumps_before="rock", stones=0.25, plants=0.0, at_foot=True,
        ripples=Ripples(0.07, 0.4, 0.22, 0.08, "beach_share * (1.0 - rock_share) * (1.0 - snow_share)")),
    # The line is as wide as the hidden relief spreads it.
    Material("snow", "above its line: higher on sunny slopes, lower in winter; thin on steep faces", "ground", """
        float hidden = min(0.25 * hidden_slope * footprint_m * warmth_per_m, 0.12);
        float spread = 0.012 + 0.6 * hidden + 0.06 * winter;
        float melts = warmth - 0.46 * winter + 0.06 * sunny
            - (0.006 + 0.25 * hidden + 0.03 * winter) * grain - (0.012 + 0.02 * winter) * mixed;
        float snowy = smoothstep(spread, -spread, melts);
        float sheds = (slope - snow_slope) / (0.25 * snow_slope + hidden_slope) + 0.25 * grain + 0.2 * mixed
            + 0.5 * sunny;
        return snowy * (1.0 - 0.9 * smoothstep(-1.0, 1.0, sheds));
        """, "snow_albedo", "albedo * (1.0 + 0.03 * patches + 0.025 * grain)",
        buries=0.5, stones=0.0, plants=0.0, hides_trees=False, ripples=Ripples(1.15, 0.9, 0.16, 0.02)),
)  # fmt: skip
"""The library's own; within a mixture later ones lie over earlier ones."""
