"""Photographs of writing: the sheet, its light, its inks, and the strokes with their dryness."""
