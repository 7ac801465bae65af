"""Logs of the stream: writing, reading, the live table, MCAP."""
