"""Stability: limits by bisection beside the theory, maps, units, and long runs."""
