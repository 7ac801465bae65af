"""Every function that touches pixels, in viper's language: one text for three executors.

On a board viper compiles it, on a PC numba does, and the strict stand-in of `larics._cpython` proves
that no int32 overflows. The rules that make all of them give the same bytes:

- index style only: `p[i]`, loads wrapped in `int()`, no calls, no `for`, no defaults, no unary minus
- arguments are pointers or ints; the first two locals (arguments first) live in registers, so the hot ones
  come first and some arguments exist only to be such a register
- in the loops that cost most `x >> 31` tells a negative number, `while i - end` ends a count and `a & mask` a
  turn: viper makes five instructions of a comparison where a difference or a shift takes one to three
- every intermediate within +-2**30, divisors never zero, no shift by more than 31
- a negative value in a ptr32 buffer is loaded as `((int(p[i]) & 0x3FFFFFFF) ^ 0x20000000) - 0x20000000`
  (32-bit boards load it signed, 64-bit ones unsigned); tables for ptr16 are biased instead
- no bounds checks on a board: the callers validate, the strict executor checks
- at most 12 arguments: what belongs together is an array, whose items are named once, in layouts.py; who uses
  an item repeats it as a constant of its own, and the rule checker compares

One module per step of the pipeline; each holds viper functions and nothing else.
"""
