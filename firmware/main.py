"""What the board starts at power-up."""

import start

start.main()
