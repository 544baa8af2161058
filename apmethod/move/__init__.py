"""Move: from what was received to a displacement (paper 3.1). No neighbours here."""
