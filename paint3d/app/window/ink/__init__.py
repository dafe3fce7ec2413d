"""Inks: the panel, mixing a colour, the user's tables."""
