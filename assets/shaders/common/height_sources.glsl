// Contract "height_sources", default: all that the ground may be made of beside noise. The terrain system leaves out
// what its ground is not, so that it costs nothing: even loops without a turn do, in a shader of this size.
//
//   TERRAIN_CRATERED, TERRAIN_MAPPED   the height function may have craters, a height map
//   TERRAIN_TILED                      some of it is real elevation, from tiles; never with TERRAIN_MAPPED
//   TERRAIN_RIVERS                     there are rivers and lakes
//   TERRAIN_WOODED                     a map says where forests are
//   TERRAIN_CARVED                     those carve the ground; only with TERRAIN_RIVERS
//   TERRAIN_ERODED                     some of its relief is gullies
//   TERRAIN_COLORED                    the ground may have a colour map
//   TERRAIN_PICTURED                   some of it has pictures, from tiles; never with TERRAIN_COLORED
//   TERRAIN_SOURCES_CHOSEN             whoever compiles has said so already (measurements)
#ifndef TERRAIN_SOURCES_CHOSEN
#define TERRAIN_CRATERED
#define TERRAIN_MAPPED
#define TERRAIN_COLORED
#endif
