"""Benchmarks that users run: neighbours, sums and whole steps, each checked before it is timed."""
