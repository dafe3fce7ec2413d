"""Seals on the command line."""
