"""The command line: ``python -m catena simulate arm.urdf``."""

import sys

from ._catena import main as _main


def main():
    """Does what the command line says, and ends with its exit code."""
    sys.exit(_main(["catena", *sys.argv[1:]]))


if __name__ == "__main__":
    main()
