"""Error against run time: every method, the programs people would use instead, the extremes."""
