from paint3d.cli.painting import Painting as Painting
from paint3d.cli.painting import PaintOptions as PaintOptions
from paint3d.cli.painting import prepare as prepare
from paint3d.cli.painting import write_report as write_report
from paint3d.cli.parsing import UsageError as UsageError
