"""The cells of the coded family: read through the pose that either reader has fitted."""
