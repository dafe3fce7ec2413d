"""Seals: characters or a drawing cut into a stone, and what the stone leaves on a surface."""
