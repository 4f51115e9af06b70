"""The methods of van den Bergh's paper, by name, as a reference to which the exact engines are compared."""
