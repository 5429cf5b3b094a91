"""What can go wrong, with the messages of the command line."""


class CatenaError(Exception):
    """Anything that catena refuses or fails at."""


class InputError(CatenaError, ValueError):
    """What was given is wrong: a file, a joint, a number, an option. Nothing was run or written."""


class RunError(CatenaError, RuntimeError):
    """A run failed part-way: a step, a controller, a full disk. Its log is complete up to there."""


def no_joint(name, known):
    """The error of a joint that is not among those that move."""
    return InputError(f"there is no joint {name!r}; the joints that move are {', '.join(map(repr, known))}")
