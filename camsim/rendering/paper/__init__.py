"""Methods of a paper, by name, as a reference to which the exact engines are compared."""
