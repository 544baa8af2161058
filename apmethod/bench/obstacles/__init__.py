"""First walls on displacements against the peers that are installed."""
