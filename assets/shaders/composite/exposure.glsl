// The exposure of a frame, written by composite/meter.comp, read by all that follows.
struct Exposure {
    float ev100;         // in use
    float target_ev100;  // what the scene asks for
    float metered;       // log2 of the metered luminance in cd m^-2
    float saturated;     // luminance in cd m^-2 that exposes to 1
};
