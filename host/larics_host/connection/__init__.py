"""Talking to a camera: byte sources, receiver, client."""
