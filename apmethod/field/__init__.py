"""Scenes whose agents carry a field: its start, the named accuracies, laying agents anew."""
