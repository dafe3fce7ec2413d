"""Brushes as parameters: presets, bent shapes, dynamics, and the footprint they leave."""
