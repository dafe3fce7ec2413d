"""How fast the program is on this machine: tables, and ratios measured within one run.

`paint3d.bench.registry` lists the benchmarks. Machines are shared and noisy, so every figure is
the best of several rounds, competitors take turns, and CPU time stands beside wall time.
"""

from paint3d.core.face import late_face

__getattr__, __dir__ = late_face(__name__)
