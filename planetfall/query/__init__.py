"""Numbers without pictures: heights, sea, air and clouds at points of a scene."""
