"""Numbers in sentences."""


def counted(number, noun):
    """`1 frame`, `0 frames`, `2 frames`: a number with its noun, given in the singular."""
    return "%d %s%s" % (number, noun, "" if number == 1 else "s")
