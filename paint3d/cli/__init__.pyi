from .options import UsageError as UsageError
from .painting import PaintingOptions as PaintingOptions
from .painting import prepare as prepare
from .results import PaintingResult as PaintingResult
from .results import write_report as write_report
