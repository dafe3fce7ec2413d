"""From text to strokes: glyphs, layout, and the planning of the motion that writes them."""

from paint3d.core.face import late_face

__getattr__, __dir__ = late_face(__name__)
