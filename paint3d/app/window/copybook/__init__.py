"""Copybooks: the panel, ghosts on the object, strokes read from pictures."""
