"""What hands hold: reports in, readings out, and forces back."""

from paint3d.core.face import late_face

__getattr__, __dir__ = late_face(__name__)
