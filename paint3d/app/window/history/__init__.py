"""The strokes of a painting: the panel, going back, edits."""
