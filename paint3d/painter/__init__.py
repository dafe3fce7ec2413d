"""The painter: runs recordings and live hands through the brush engine onto a surface."""

from paint3d.core.face import late_face

__getattr__, __dir__ = late_face(__name__)
