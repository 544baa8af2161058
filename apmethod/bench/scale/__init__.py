"""Cost and memory of an agent as they become many."""
