"""Inks: the panel, mixing a colour, tables of one's own."""
