from .options import UsageError as UsageError
from .replay import PaintOptions as PaintOptions
from .replay import prepare as prepare
from .results import Painting as Painting
from .results import write_report as write_report
