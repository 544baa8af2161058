"""Run: scenes found, built, run to their end and reported, from the command line or not."""
