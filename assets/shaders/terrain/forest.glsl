// What a forest does to the ground's light: shadows of its trees near the camera, its own colour far away.
#include "cover/snow_share.glsl"
#include "terrain/stands.glsl"
#ifdef COVER_SHRINKS
const float CROWNS_FROM = 0.62 * float(GROUND_COVER);   // metres, as engine/surface/crowns.py has it
#endif
#ifdef COVER_CROWNS
#include "terrain/crowns.glsl"
const vec3 CROWN_TINT = vec3(0.36, 0.24, 0.20);      // of crowns, from one to another
const vec3 CROWN_AUTUMN = vec3(0.45, 0.90, 0.40);    // where they have turned
#endif

const vec2 CANOPY_FROM = vec2(0.72, 1.0);   // shares of the trees' reach in which it takes over
const vec4 SAVANNA_HUMID = vec4(0.38, 0.46, 0.55, 0.49);   // as systems/cover/growth.py has them
const vec2 SAVANNA_WARM = vec2(0.40, 0.60);
const float CONIFERS_GROUND = 0.47;         // area of a conifer's crown over a broadleaf's of the same age
const vec2 CROWNS_TALL = vec2(1.0, 1.68);   // a crown's outline from the side over its area from above, of both
// Of the sun that comes to crowns, what their leaves throw back: always, the higher it stands the more, where it is
// behind the eye, and of conifers by the cosine of the angle between both. Of the sky.
const vec4 CROWNS_SUNNY = vec4(0.219, 0.210, 0.050, 0.128);
const vec2 SNOW_SEEN = vec2(0.53, 0.135);   // of crowns full of snow, white: always, and the higher the eye is
const float SNOW_TWIGS = 1.10;              // of that, on broadleaves, which are bare where it snows
const vec2 SNOW_CROWN = vec2(0.32, 1.05);   // and of one of them: always, and by how far its side faces up
const float CROWNS_SKY = 0.37, GROUND_BETWEEN = 0.957, HOT_SPOT = 16.4;

// How full of snow crowns are, 0..1: what cover/snow.glsl makes white of them, over what it makes white at most.
float snow_on_trees(float warmth, float latitude_sine, float conifer) {
    float share = snow_share(cover_map.snow.w, cover_map.winter, warmth, latitude_sine);
    return share * (0.65 + 0.35 * share) * mix(SNOW_TWIGS, 1.0, conifer);
}

// Share of places that have a tree, in forest or savanna.
float trees_grown(Ground ground, Material material) {
    float savanna = ramp(SAVANNA_HUMID.x, SAVANNA_HUMID.y, ground.mean_humidity)
        * ramp(SAVANNA_HUMID.z, SAVANNA_HUMID.w, ground.mean_humidity)
        * ramp(SAVANNA_WARM.x, SAVANNA_WARM.y, ground.mean_warmth);
    return max(material.growth.trees, cover_map.savanna * savanna * material.growth.tufts);
}

// The shadows of trees; and beyond them a forest's own colour: crowns that stand by chance, so that the share of a view
// or of the sun's light that comes between them falls with e^-(their area across it), and what a view and the sun both
// reach is the law of Lommel and Seeliger. The constants are fitted to pictures of trees as solids
// (planetfall bench cover.far). The clutter's small trees give way to both.
void cover_ground(Spot s, Ground ground, vec3 normal, inout Material material, inout vec2 open) {
    float far = smoothstep(CANOPY_FROM.x, CANOPY_FROM.y, s.distance_m * (1.0 / float(GROUND_COVER)));
    float left = far < 1.0 ? cover_light(s.point, 0.3) : 1.0;
#ifdef COVER_SHRINKS
    // As trees shrink their shadows go.
    left = mix(left, 1.0, clamp((s.distance_m - CROWNS_FROM) * (1.0 / (0.28 * float(GROUND_COVER))), 0.0, 1.0));
#endif
    // What takes the sun away takes some of the sky as well.
    open *= vec2(left, mix(0.6, 1.0, left));
    far *= material.inland;
    float trees = trees_grown(ground, material);
    Stand stand = far > 0.0 && trees > 0.0 ? stand_at(s.D, ground.region, ground.footprint_m) : Stand(0.0, 0.0, 0.0);
    trees *= 1.0 - stand.open;
    // As systems/cover/stand.py has it.
    float conifer = ramp(0.62, 0.34, ground.mean_warmth + STAND_CONIFERS * stand.hue);
    vec2 sizes = 1.0 + STAND_SIZES * stand.age;
    float grown = ramp(0.10, 0.34, ground.mean_warmth);
    vec4 broadleaf = mix(vec4(cover_map.broadleaf, 1.0), s.zenith.z < 0.0 ? cover_map.south : cover_map.north,
        ramp(SEASONAL.x, SEASONAL.y, abs(s.zenith.z)));
    float area = cover_map.crowns * stand_crowns(stand) * grown * mix(broadleaf.a, CONIFERS_GROUND, conifer)
        * trees * clamp(0.8 + 0.5 * ground.mixed, 0.0, 1.5);
    float tall = mix(CROWNS_TALL.x, CROWNS_TALL.y, conifer), mu = max(dot(normal, frame.sun_direction), 0.1);
    vec2 rise = clamp(vec2(dot(s.view, s.zenith), dot(frame.sun_direction, s.zenith)), 0.1, 1.0);
    vec2 across = area * sqrt(1.0 + tall * tall * (1.0 / (rise * rise) - 1.0));   // to the eye, to the sun
    vec2 between = exp(-across);
    float both = across.x / (across.x + across.y + 1e-3) * (1.0 - between.x * between.y) / mu;
    float phase = dot(s.view, frame.sun_direction), hot = exp(HOT_SPOT * (phase - 1.0));
    both *= dot(CROWNS_SUNNY, vec4(1.0, rise.y, hot, conifer * phase));
    vec3 leaves = mix(broadleaf.rgb, cover_map.conifer, conifer) * (1.0 + stand.hue * HUE_TINT);
    float snow = snow_on_trees(ground.mean_warmth, s.zenith.z, conifer);
    float whiter = clamp(snow * dot(SNOW_SEEN, vec2(1.0, rise.x)), 0.0, 1.0);
    vec3 many = mix(leaves, cover_map.snow.rgb, whiter) * (1.0 + stand_grain() * ground.grain);
    vec3 sunlit = many * both + material.albedo * (GROUND_BETWEEN * between.x * between.y);
    vec3 skylit = mix(many * CROWNS_SKY, material.albedo * (0.5 + 0.5 * between.x), between.x);
    sunlit = mix(material.albedo, sunlit, far);
    skylit = mix(material.albedo, skylit, far);
#ifdef COVER_CROWNS
    float stands = trees * clamp(0.8 + 0.5 * ground.mixed, 0.0, 1.5) * material.inland;
    Crowns crowns = crowns_seen(s, stands, conifer, cover_map.wide_m * sqrt(grown) * sizes.x,
        cover_map.tall_m * sqrt(grown) * sizes.y, across.y * far);
    // In autumn red or green is less of it.
    float turned = (1.0 - conifer) * ramp(0.75, 0.5, broadleaf.g / max(broadleaf.r, 1e-3));
    vec3 single = leaves
        * (1.0 + crowns.tint * mix(CROWN_TINT, CROWN_AUTUMN, turned) + cover_map.variety * crowns.hue * HUE_TINT);
    float white = snow * dot(SNOW_CROWN, vec2(1.0, crowns.up / max(crowns.met, 1e-3)));
    single = mix(single, cover_map.snow.rgb, clamp(white, 0.0, 1.0));
    float unknown = 1.0 - crowns.met - crowns.left;
    vec3 shown = single * (both / max(1.0 - between.x, 1e-3) * crowns.light)
        + crowns.left * crowns.sun * mix(1.0, GROUND_BETWEEN, far) * material.albedo;
    vec3 shown_sky = single * (CROWNS_SKY * crowns.sky)
        + crowns.left * mix(1.0, 0.5 + 0.5 * between.x, far) * material.albedo;
    sunlit = mix(sunlit, shown + unknown * sunlit, crowns.here);
    skylit = mix(skylit, shown_sky + unknown * skylit, crowns.here);
#endif
    // One albedo is for both.
    open.y *= dot(skylit, vec3(1.0)) / max(dot(sunlit, vec3(1.0)), 1e-4);
    material.albedo = sunlit;
    material.growth.trees = 0.0;
}
