"""Imports of painting a row, once, in the server that a batch's processes are forked from.

Importing takes a second, forking ten milliseconds. Nothing here starts a thread: a fork copies only
the thread that forks. An interrupt meant for the batch is kept from the server until here; where
the batch is at its end before all is imported, so is the server.
"""

from __future__ import annotations

import gc
import os
import sys
import warnings
from importlib import import_module
from types import TracebackType

from paint3d.core.machine import ignore_interrupts

_NEEDED = (
    "paint3d.cli.batches.workers",
    "paint3d.files.export",
    "paint3d.files.load",
    "paint3d.painter.painter",
    "paint3d.calligraphy.glyph_sources",
    "paint3d.calligraphy.writing",
    "paint3d.surface.painted_surface",
)


def _tell(kind: type[BaseException], error: BaseException, where: TracebackType | None) -> None:
    """Print an error, but not that of a half-received request: the batch has ended."""
    if not issubclass(kind, EOFError):
        sys.__excepthook__(kind, error, where)


ignore_interrupts()  # the batch stops what it has started
sys.excepthook = _tell
_batch = os.getppid()
if not sys.warnoptions:
    warnings.simplefilter("ignore")
for _name in _NEEDED:
    if os.getppid() != _batch:
        os._exit(0)
    import_module(_name)
gc.freeze()  # what is shared stays shared: collecting would write to it
