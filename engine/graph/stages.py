"""The places at which passes write into a picture that many share, from the first to the last."""

STAGES = (
    "opaque",  # the solid ground, into the G-buffer and into the light of the scene
    "plants",  # trees and shrubs, and their light: before the water that mirrors them
    "water",  # the surface of the sea, where it is nearer than the ground
    "objects",  # what stands on both or floats, and its shadows on them
    "detail",  # corrections of the G-buffer once the tiles of each surface are known: coasts, waves of single pixels
    "sky",  # what is seen where no surface is, beyond the air: stars
    "underwater",  # the water between the lens and all of that
    "clouds",  # clouds, over whatever they hide
    "overlay",  # what is drawn over all light of the library: the passes of games
    "debug",  # what replaces the finished picture while someone looks for a mistake
)
"""For stage= of `GraphBuilder.add_pass`."""

RANK = {name: place for place, name in enumerate(STAGES)}
