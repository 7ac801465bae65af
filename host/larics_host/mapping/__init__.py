"""What `larics map` is made of.

mapfile   the map as a file: versioned JSON with size, height and heading of each marker
check     what no map can be, and what no vehicle can drive
links     from logs: which markers were seen together, and how they lie to each other
build     places that agree with all links and given distances
draw      the map as a picture
"""
