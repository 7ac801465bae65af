"""Fixed-point numbers and their tables: the ground floor."""
