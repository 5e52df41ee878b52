// In place of the frame's block (engine/frame/block.py) where a probe asks: every question is a camera of its own, and
// its anchor.
struct AskedFrame {
    vec4 camera_right, camera_up, camera_forward, projection, camera_offset, camera_zenith, anchor_up, sun_direction,
        sun_irradiance,
        viewport, clock, scale;
};

AskedFrame frame;
