"""The direct reader: reads a candidate by what a sharp picture must show."""
