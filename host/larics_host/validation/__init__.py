"""What `larics validate` is made of: detections held against the truth, or one log against another.

sources    detections from a method run here, or from a log of an earlier run
outcome    what became of every marker: rates, errors, confusion, the worst frames
board      messages made here from frames, against those that the board sent
report     all of it as one HTML file
"""
