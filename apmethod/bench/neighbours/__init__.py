"""The paper's study of its quad-lattice (2.4.3), repeated."""
