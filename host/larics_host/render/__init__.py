"""The frame renderer: a pin-hole camera in 3-D under a ceiling with markers."""
