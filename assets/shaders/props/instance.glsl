// Props as their system packs them (systems/props/instances.py): camera-relative metres, planet axes.
struct PropInstance {
    vec4 a;       // the object's axes times its size
    vec4 b;
    vec4 c;
    vec4 place;   // of its origin, from the camera
    vec4 color;   // reflectance, roughness
    vec4 back_a;  // of the last frame minus those now
    vec4 back_b;
    vec4 back_c;
    vec4 back;    // the same of its origin; w: 1 if it was there
};
struct PropOccluder {
    vec4 a;       // half axes
    vec4 b;
    vec4 c;
    vec4 place;   // of its middle, from the camera; w: 0 an ellipsoid, 1 a box
};
