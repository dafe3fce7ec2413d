"""Triangles: the object as it came, its refined copy that is painted, and questions to either."""
