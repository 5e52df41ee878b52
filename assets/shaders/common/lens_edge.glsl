// The water's edge on the lens.

const float WATERLINE_PX = 60.0;   // above it, no ground or sea that the drawn waves may have on their other side
