"""What OpenMV's snapshot returns: an image that is valid until the next snapshot."""


class Image:
    def __init__(self, width, height, pixels):
        self._width = width
        self._height = height
        self._pixels = pixels

    def width(self):
        return self._width

    def height(self):
        return self._height

    def bytearray(self):
        """By reference: the next snapshot writes into the same memory."""
        return self._pixels
