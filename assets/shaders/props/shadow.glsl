// How much of the sun and of the sky a prop hides from a point: closed forms for an ellipsoid and a box.
const float PROP_REACH = 3.0;            // around a prop, in its radii, ambient light is taken away
const float PROP_SHADOW_RADII = 90.0;    // a shadow is at most so many radii long

float prop_radius(PropOccluder prop) {
    float a = dot(prop.a_m, prop.a_m), b = dot(prop.b_m, prop.b_m), c = dot(prop.c_m, prop.c_m);
    return prop.is_box > 0.5 ? sqrt(a + b + c) : sqrt(max(a, max(b, c)));
}

// Length of the shadow: enough for level ground below, more where the sun is low. 0 when the sun has set for it.
float prop_shadow_m(PropOccluder prop) {
    float height = dot(up_at(prop.place_m), frame.sun_direction);
    float radius = prop_radius(prop);
    return height > -0.05 ? radius * clamp(8.0 / max(height, 0.02), 24.0, PROP_SHADOW_RADII) : 0.0;
}

// A point's place in the prop's own axes, in which it is a unit sphere or a box from -1 to 1.
vec3 prop_local(PropOccluder prop, vec3 vector) {
    return vec3(dot(vector, prop.a_m) / dot(prop.a_m, prop.a_m),
        dot(vector, prop.b_m) / dot(prop.b_m, prop.b_m),
        dot(vector, prop.c_m) / dot(prop.c_m, prop.c_m));
}

float prop_box_hit(vec3 from, vec3 slopes, float half_side) {
    vec3 one = (-half_side - from) * slopes, two = (half_side - from) * slopes;
    vec3 low = min(one, two), high = max(one, two);
    float enter = max(max(low.x, low.y), low.z), leave = min(min(high.x, high.y), high.z);
    return leave > max(enter, 0.0) ? 1.0 : 0.0;
}

// Share of the sun's disc that the prop leaves of it at camera-relative `point`. own: below this place in the prop's
// axes a point belongs to the prop itself, which its own normals shade.
float prop_sun(PropOccluder prop, vec3 point, float own) {
    vec3 sun = frame.sun_direction, from = prop_local(prop, point - prop.place_m), direction = prop_local(prop, sun);
    float inside = prop.is_box > 0.5 ? max(abs(from.x), max(abs(from.y), abs(from.z))) : length(from);
    float t = -dot(from, direction) / dot(direction, direction);   // metres to the nearest approach
    vec3 nearest = from + direction * t;
    float miss = length(nearest);
    vec3 aside = nearest / max(miss, 1e-6);
    float across = length(prop.a_m * aside.x + prop.b_m * aside.y + prop.c_m * aside.z);
    float soft = max(t, 0.0) * frame.sun_radius_rad / max(across, 1e-6);
    // Farther than the umbra is long the prop covers a part of the disc only.
    float most = min(1.0, 1.0 / max(soft * soft, 1e-6));
    float width = clamp(soft, 0.01, 1.0);
    float hidden = 1.0 - smoothstep(1.0 - width, 1.0 + width, miss);
    if (prop.is_box > 0.5) {
        vec3 slopes = 1.0 / mix(direction, vec3(1e-9), lessThan(abs(direction), vec3(1e-9)));
        hidden = 0.25 * (prop_box_hit(from, slopes, 1.0 - 0.75 * width)
            + prop_box_hit(from, slopes, 1.0 - 0.25 * width)
            + prop_box_hit(from, slopes, 1.0 + 0.25 * width) + prop_box_hit(from, slopes, 1.0 + 0.75 * width));
    }
    hidden *= most * (1.0 - smoothstep(0.7, 1.0, t / prop_shadow_m(prop)));
    return inside < own || t <= 0.0 ? 1.0 : 1.0 - hidden;
}

// Share of the sky above `normal` that the prop leaves: a sphere of its volume covers r^2 / d^2 times the cosine.
float prop_ambient(PropOccluder prop, vec3 point, vec3 normal, float own) {
    vec3 from = prop_local(prop, point - prop.place_m);
    float inside = prop.is_box > 0.5 ? max(abs(from.x), max(abs(from.y), abs(from.z))) : length(from);
    vec3 away = prop.place_m - point;
    float volume = abs(dot(prop.a_m, cross(prop.b_m, prop.c_m)));
    float r = pow(volume * (prop.is_box > 0.5 ? 1.9 : 1.0), 1.0 / 3.0), d = max(length(away), r);
    float reach = prop_radius(prop) * PROP_REACH;
    float covered = clamp(0.5 + 0.5 * dot(normal, away) / d, 0.0, 1.0) * r * r / (d * d);
    return inside < own ? 1.0 : 1.0 - 0.9 * covered * (1.0 - smoothstep(0.5, 1.0, d / reach));
}
