"""Launch files and configuration around the command `larics ros2`; there is no code of its own."""
