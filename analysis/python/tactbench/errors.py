"""What the package refuses, in words: what, where, and how to mend it."""


class TactbenchError(Exception):
    """A file, run or model that cannot be used as asked."""


class MissingPackage(TactbenchError, ImportError):
    """A package of Python that is optional here, and needed for what was asked."""


def package(name, purpose):
    """Imports `name`. Raises MissingPackage that says which package to install."""
    try:
        return __import__(name)
    except ImportError as error:
        raise MissingPackage(f"{purpose} needs the package {name}, which this Python does not have: "
                             f"apt install python3-{name}, or pip install {name}") from error
