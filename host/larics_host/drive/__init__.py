"""A vehicle drives in closed loop under a rendered ceiling, by the real firmware and the reference behaviour.

field      where the markers hang, in what light, and what happens on the way
vehicle    the differential drive: wheel noise, delay, lag
firmware   the firmware as a process: frames in, messages of the wire out
simulation one drive: everything put together, and what was recorded
score      figures of a drive; figures: pictures of it
"""
