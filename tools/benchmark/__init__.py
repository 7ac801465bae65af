"""What `tools/bench.py` and `tools/rates.py` are made of: frames, methods, plots."""
