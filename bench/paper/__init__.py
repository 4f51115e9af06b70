"""The paper's square, tables and times, and the programs that people would use instead; ``make bench``."""
