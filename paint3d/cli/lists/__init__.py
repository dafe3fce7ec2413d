"""Commands that list brushes, inks, materials and fonts."""
