"""What `larics calibrate` is made of: a camera in floating point, and what frames of markers say about it.

model      the camera that larics.locate.camera_model computes in integers
observe    markers seen in frames
lens       focal length, tilt and distortion from the sizes of rings
turn       rotation centre and mounting angle from a vehicle that turns and drives
plots      what the residuals look like
"""
