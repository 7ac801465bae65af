"""Putting the firmware on a board: finding it, building for it, copying so that it always starts.

Modules: ports (which serial port), session (talking to the board's REPL), build (.mpy files), install (the
two program folders and the order of copying).
"""
