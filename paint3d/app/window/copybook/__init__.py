"""Copybooks: the panel, ghosts on the object, strokes found in pictures."""
