from .painter import Painter as Painter
