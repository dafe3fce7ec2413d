from .bristle_state import HairTuft as HairTuft
from .flat_input import LaidPad as LaidPad
from .painter import Painter as Painter
