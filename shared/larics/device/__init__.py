"""From settings to a running sensor: factory, measurements, messages of a frame, outbox, commands."""
