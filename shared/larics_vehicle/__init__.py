"""Reference behaviour of the vehicle's controller, in the language of the board."""
