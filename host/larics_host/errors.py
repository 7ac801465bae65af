"""The one error that a user may see."""


class UserError(Exception):
    """Bad input: its text is one line that says what is wrong and what to do."""
