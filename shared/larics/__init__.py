"""LARICS marker detection, decoding and protocol: integers only, equal on board and PC."""

__version__ = "1.0.0"
