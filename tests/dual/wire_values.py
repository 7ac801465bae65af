"""Values of messages by the names of their fields, for tests on both interpreters."""

from larics.wire import codec


def at(number, name):
    """The index of a field. ValueError when the type has none of this name."""
    return [field[0] for field in codec.fields(number)].index(name)


def message_values(number, **given):
    """The values of a message, in field order: those given, else what is next to 0 within the range."""
    values = []
    for name, code, _, low, high, _ in codec.fields(number):
        none = bytes(int(code[:-1])) if code[-1] == "s" else min(max(0, low), high)
        values.append(given.pop(name, none))
    assert not given, given
    return values


def named(number, values):
    """{name: value} of a message."""
    return {field[0]: value for field, value in zip(codec.fields(number), values)}


def changed(number, values, **given):
    """The values with other ones in the fields given."""
    result = list(values)
    for name in given:
        result[at(number, name)] = given[name]
    return result
