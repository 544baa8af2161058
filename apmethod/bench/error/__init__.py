"""``apmethod bench error``: error against run time, for agents and for finite elements."""
