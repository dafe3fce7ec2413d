"""An argument parser that raises instead of printing its usage over several lines."""

from __future__ import annotations

import argparse
from typing import Never

__all__ = ["Parser", "UsageError"]


class UsageError(Exception):
    """A command line that argparse refused."""


class Parser(argparse.ArgumentParser):
    """Raises `UsageError` with one line."""

    def error(self, message: str) -> Never:
        """Refuse the command line."""
        raise UsageError(f"{message} (see {self.prog} --help)")
