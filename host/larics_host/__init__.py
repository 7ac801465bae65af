"""The `larics` command and what it is made of: PC only."""
