"""`make demo`: a rendered drive -> firmware on real MicroPython -> serial line -> table and picture."""
