"""LARICS marker detection, decoding and protocol: integers only, the same bytes on a camera board and a PC."""

__version__ = "0.1.0"
