"""Triangles: the object as it came, its refined copy that is painted, and questions to either."""

from paint3d.core.face import late_face

__getattr__, __dir__ = late_face(__name__)
