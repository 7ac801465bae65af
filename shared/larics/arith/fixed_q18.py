"""Fractions in 1/2**18 within 30-bit integers: finer than `larics.arith.fixed`, and dearer."""

from larics.arith.fixed import isqrt, wrap_cdeg


def mul(a, b):
    """a * b / 2**18, rounded; |a * b| < 2**38 and |a| < 2**20."""
    return (a * (b >> 9) + (a * (b & 511) >> 9) + 256) >> 9


def div(a, b):
    """a * 2**18 / b, rounded; |a| < 2**30, 0 < b < 2**20, |a / b| < 2**11."""
    whole = a // b
    rest = (a - whole * b) << 9
    middle = rest // b
    rest = (rest - middle * b) << 9
    return (whole << 18) + (middle << 9) + (rest + (b >> 1)) // b


def root(value):
    """Square root of a q18 below 4.0, to the last digit or two."""
    value <<= 10
    coarse = isqrt(value)  # q14, and its remainder gives four bits more
    return (coarse << 4) + ((value - coarse * coarse) << 3) // coarse if coarse else 0


def sin_cos(angle_cdeg):
    """Sine and cosine, exact to the last digit, by their series in long integers: not for every frame."""
    x = wrap_cdeg(angle_cdeg) * 3454217652358 // 18000  # pi in q40
    sums = [1 << 40, x, 0, 0]  # the derivatives of the sine repeat after four terms
    term = x
    for n in range(2, 32):
        term = (term * x >> 40) // n
        sums[n & 3] += term
    return (sums[1] - sums[3] + (1 << 21)) >> 22, (sums[0] - sums[2] + (1 << 21)) >> 22


def product(a, b):
    """Product of two 3x3 matrices as lists of rows, in long integers."""
    return [[sum((a[i][k] * b[k][j] for k in range(3)), 1 << 17) >> 18 for j in range(3)] for i in range(3)]
