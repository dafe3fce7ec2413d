"""How fast the program is on this machine: tables, and ratios measured within one run.

`paint3d.bench.registry` lists the benchmarks. Machines are shared and noisy, so every figure is
the best of several rounds, competitors take turns, and CPU time stands beside wall time.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
