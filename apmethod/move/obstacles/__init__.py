"""Obstacles: kd-tree-domains, rays, and agents that never end up inside a wall (paper 2.5)."""
