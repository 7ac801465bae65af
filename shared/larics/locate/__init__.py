"""Where the camera is: camera model, map, pose, motion, noise, route."""
