"""Camera drivers behind one interface, so that the loop does not know which camera it has.

A driver has
    width, height   size of what `frame` holds, known after start()
    frame           8-bit pixels, row-major, width * height; valid until the next grab()
    frame_number    counts every frame the camera has made, also those nobody fetched
    capture_us      time.ticks_us() in the middle of the exposure of `frame`, or earlier: where nothing tells
                    when a frame was complete, it is the time at which the driver was last asked and had none,
                    so that the age is never told too small
    skipped         frames the camera made and nobody fetched
    ended           True when no further frame can come (recordings only)
    adjustable      False when exposure and gain change nothing, nor does another start (recordings only; may
                    be left out)
    opening         True while start() goes on in the background, for as long as the camera is not there; such
                    a driver is not started again meanwhile (may be left out)
and
    start()                  open the camera and begin to capture
    grab() -> bool           True: `frame` is the newest frame; False: none has come since the last call.
                             Never waits. Raises CameraError or OSError when the camera fails
    exposure(us=None)        set when given; returns the exposure time in use, microseconds
    gain(cdb=None)           set when given; returns the gain in use, 0.01 dB
    stop()                   release the camera; start() may be called again
"""


class CameraError(Exception):
    """The camera does not deliver; the message says what happened."""
