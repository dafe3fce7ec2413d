"""What painting a row needs, imported once, by the server that a batch's processes are forked from.

Importing takes a second, forking ten milliseconds. Nothing here starts a thread: a fork copies only
the thread that forks.
"""

from __future__ import annotations

import gc
import sys
import warnings

if not sys.warnoptions:
    warnings.simplefilter("ignore")

import paint3d.cli.batch_workers
import paint3d.files.export
import paint3d.files.load
import paint3d.stroke.engine
import paint3d.stroke.glyph_sources
import paint3d.stroke.writing
import paint3d.surface.painted_surface  # noqa: F401

gc.freeze()  # what is shared stays shared: collecting would write to it
