"""Input by the hand over the picture: pens, mice, fingers, keys and devices."""
