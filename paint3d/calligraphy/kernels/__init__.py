"""The hot loops of planning: distance fields, rasters."""
