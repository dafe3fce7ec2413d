from paint3d.cli.parsing import UsageError as UsageError
from paint3d.cli.replay import PaintOptions as PaintOptions
from paint3d.cli.replay import prepare as prepare
from paint3d.cli.results import Painting as Painting
from paint3d.cli.results import write_report as write_report
