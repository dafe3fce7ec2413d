"""``python -m paint3d`` is the ``paint3d`` command."""

import sys

_INTERRUPTED = 130


def run() -> int:
    """Run the command line; an interrupt is told in one line before it is even loaded, too.

    Returns
    -------
    int
        The exit status; see `paint3d.cli.main`.
    """
    try:
        from paint3d.cli.main import main
    except KeyboardInterrupt:
        sys.stderr.write("paint3d: error: interrupted\n")
        return _INTERRUPTED
    return main()


if __name__ == "__main__":
    sys.exit(run())
