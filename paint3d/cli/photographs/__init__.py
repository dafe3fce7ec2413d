"""Photographs of writing on the command line."""
