from paint3d.painter.bristle_state import HairTuft as HairTuft
from paint3d.painter.flat_input import LaidPad as LaidPad
from paint3d.painter.painter import Painter as Painter
