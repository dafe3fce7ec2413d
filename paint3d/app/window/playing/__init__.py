"""Recordings that are played, pictures and films."""
