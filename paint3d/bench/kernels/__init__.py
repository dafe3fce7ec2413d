"""Loops that only benchmarks run."""
