"""Message: deliver contributions to both ends of a pair (paper 2.3). No formulas here."""
