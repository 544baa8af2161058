"""Contribute: what a pair gives (paper 2.1 and 2.3). No agents here, only formulas."""
