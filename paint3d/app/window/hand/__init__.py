"""What the hand does over the picture: pens, mice, fingers, keys and devices."""
