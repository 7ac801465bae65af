"""An int that refuses to leave the small integers of a 32-bit board, where larger ones need the heap."""


class Small(int):
    """An int whose arithmetic, with any int, stays a Small or raises AssertionError."""


def _small(name):
    plain = getattr(int, name)

    def operate(self, *others):
        value = plain(self, *others)
        if value is NotImplemented:
            return value
        assert -(1 << 30) <= value < 1 << 30, (name, int(self), others)
        return Small(value)

    setattr(Small, name, operate)


for _name in ["add", "sub", "mul", "floordiv", "mod", "and", "or", "xor", "rshift", "lshift"]:
    _small("__%s__" % _name)
    _small("__r%s__" % _name)
for _name in ("__neg__", "__abs__"):
    _small(_name)
