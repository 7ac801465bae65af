"""Stand-in for OpenMV's `omv` module."""

name = "OMVRT1060 32768 SDRAM"


def arch():
    return name


def version_string():
    return "5.0.0"
