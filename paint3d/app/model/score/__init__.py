"""Whole paintings as recordings: written while they are painted, played again, edited."""
