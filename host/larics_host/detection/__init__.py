"""The detector on a PC: options, batches of frames."""
