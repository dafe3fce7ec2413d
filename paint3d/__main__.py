"""``python -m paint3d`` is the ``paint3d`` command."""

import sys

from paint3d.cli.main import main

if __name__ == "__main__":
    sys.exit(main())
