"""Skills: what agents of a scene can do besides the paper's four steps (paper 2.2, 3.2)."""
