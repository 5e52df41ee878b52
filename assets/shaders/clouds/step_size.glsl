// Step sizes of the march through one interval of a layer of water: short ones in cloud, long through the clear, after
// which the march goes back and takes short ones.
#include "clouds/intervals.glsl"

// steps around the camera, where a layer's thickness has NEAREST_STEPS or more
const float NEAREST_M = 4.0, NEAREST_GROWTH = 0.02;
const float NEAREST_STEPS = 96.0;
const float LONGEST_CLEAR_SHARE = 0.25;   // of a segment, in a step through the clear
const float CLEAR_GROWTH = 1.4;           // of each step through the clear against the one before

// Finest steps: the weather and the sunlight of each place, and no wisp is stepped over.
#ifdef CLOUD_FINEST
const float CLEAR_FACTOR = 1.0, CLEAR_GAP_FACTOR = 0.0, OCCLUDED_FACTOR = 0.0;
const float SHARED_STEPS = 0.0;
const float EDGE_STEP = 1e-4;    // first and last step of an interval, of a short one
#else
const float CLEAR_FACTOR = 3.0;      // longest step through the clear, in short ones
const float CLEAR_GAP_FACTOR = 1.0;  // and longer still, per unit of noise that is missing for a cloud
const float OCCLUDED_FACTOR = 1.0;   // steps behind cloud against those before it, less one: little of it is seen
const float SHARED_STEPS = 0.5;      // short ones that share one sample of their light, beyond two
#endif

// Metres, unless it says otherwise.
struct StepSizes {
    float shortest, longest;   // of short ones
    float growth;              // m/m: of a short step with distance
    float nearest_factor;      // of steps around the camera
    float longest_averaged;    // where a pixel is too wide to show single clouds
    float per_pixel;           // shortest step, in widths of a pixel
    float clear_factor, clear_gap_factor, occluded_factor;   // as the constants above, here
    float shared_depth;        // optical depth up to which short steps share one sample of their light
    float shared_steps;        // and how many of them at most
};

StepSizes step_sizes(float thickness, float from, float to) {
    float length_m = to - from, shortest = thickness / u_layer_steps, fineness = step_fineness();
    float longest = max(length_m / (0.3 * u_layer_steps), shortest);
    // Where clouds are averaged, eight steps; who asks for more steps than pictures need gets them there, too.
    float averaged = 1.0 / max(8.0, u_layer_steps * u_layer_steps / 2000.0);
    return StepSizes(shortest, longest, max(u_step_growth, length_m / (600.0 * max(to + ray_skipped_m, 1.0))),
        max(NEAREST_STEPS / u_layer_steps, 1.0), length_m * averaged,
        0.3 * min(1.0, 2.0 * COARSE_STEPS / u_layer_steps),
        CLEAR_FACTOR, CLEAR_GAP_FACTOR, OCCLUDED_FACTOR * fineness, 48.0 / u_layer_steps,
        2.0 + SHARED_STEPS * fineness);
}

// A short step t metres along a ray that is in the layer from `from` to `to`. occluded: factor of steps behind cloud.
float step_size(StepSizes s, float t, float from, float to, float occluded) {
    float distance_m = t + ray_skipped_m, nearest = s.nearest_factor * (NEAREST_M + NEAREST_GROWTH * distance_m);
    float size = min(max(min(s.shortest, nearest), distance_m * s.growth) * occluded, s.longest);
    // Clouds that a pixel is too wide to show have smooth means.
    size = min(max(size, s.per_pixel * distance_m * pixel_rad), max(s.longest_averaged, size));
#ifdef CLOUD_FINEST
    // A low sun lights but a skin of an even layer: steps grow from where the ray enters it, and shrink to where it
    // leaves.
    size = min(size, EDGE_STEP * s.shortest + 1e-6 * t + 0.15 * min(t - from, to - t));
#endif
    return size;
}
