from paint3d.bench.registry import BENCHMARKS as BENCHMARKS
from paint3d.bench.registry import run_benchmark as run_benchmark
from paint3d.bench.result import Result as Result
