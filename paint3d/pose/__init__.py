"""From what two hands' devices say to one pose of the brush in the object's frame."""

from paint3d.core.face import late_face

__getattr__, __dir__ = late_face(__name__)
