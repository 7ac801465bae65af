"""What `larics monitor` is made of: one state, fed by a line or a log, shown in a terminal or on a web page.

state      what the messages say, ready to be shown
session    reads the line in a thread, and fetches raw frames meanwhile
drawing    the bird's-eye view as text
terminal   the view in the terminal
web        the local web page; page.html is what the browser gets
"""
