"""Whole paintings as recordings: kept while they are painted, played again, edited."""
