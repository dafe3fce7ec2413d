"""Recordings of strokes: what they hold, and the formats they are read from."""
