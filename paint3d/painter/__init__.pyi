from paint3d.painter.bristle_state import HairTuft as HairTuft
from paint3d.painter.brush_choice import choose_brush as choose_brush
from paint3d.painter.flat_input import LaidPad as LaidPad
from paint3d.painter.painter import Painter as Painter
