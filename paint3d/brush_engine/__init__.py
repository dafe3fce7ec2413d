"""Painting one stroke: pose, bent tuft, footprint, the vertices below it, ink that passes."""
