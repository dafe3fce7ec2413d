"""An argument parser that raises instead of printing its usage over several lines."""

from __future__ import annotations

import argparse
from typing import Any, Never

__all__ = ["Parser", "UsageError"]


class UsageError(Exception):
    """A command line that argparse refused."""


class Parser(argparse.ArgumentParser):
    """Raises `UsageError` with one line."""

    def parse_args(self, args: Any = None, namespace: Any = None) -> Any:
        """As argparse's, but that what is not known is told with the command that it stands at."""
        found, unknown = self.parse_known_args(args, namespace)
        if unknown:
            at = getattr(found, "command", None)
            prog = f"{self.prog} {at}" if at else self.prog
            raise UsageError(f"unrecognized arguments: {' '.join(unknown)} (see {prog} --help)")
        return found

    def error(self, message: str) -> Never:
        """Refuse the command line."""
        raise UsageError(f"{message} (see {self.prog} --help)")
