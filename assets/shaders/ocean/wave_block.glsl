// The waves of the sea as seen from the anchor; systems/ocean/wave_block.py packs them and says what each number means.
#include "generated/sea_waves.glsl"

// What is known of waves longer than 2 pi / k, and of the others.
WaveBin wave_bin(float k) {
    return sea_waves_bins(clamp(int(floor(4.0 * (log2(k) + 12.0))), 0, SEA_WAVES_BINS - 1));
}
