from .registry import BENCHMARKS as BENCHMARKS
from .registry import run_benchmark as run_benchmark
from .result import Result as Result
