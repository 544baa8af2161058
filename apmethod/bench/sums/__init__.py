"""Search and sums against the peers that are installed."""
