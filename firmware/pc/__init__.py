"""What plays a board on a computer: replay of frames, the closed loop, and their UART and camera."""
