"""The paper's animals (3.2): growth of waves, Figures 9 and 10, costs."""
