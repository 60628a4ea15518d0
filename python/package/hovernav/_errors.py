"""Exceptions of hovernav. Each message is one line with the place, the value found and the value expected."""


class Error(Exception):
    """Any error of hovernav."""


class LogError(Error):
    """A log that cannot be read or estimated: the message names the file, the line or the byte."""


class SetupError(LogError):
    """A log whose readings are impossible with its units, axes, signs or clocks: the message names the likely mistake."""


class ConfigError(Error, ValueError):
    """A setting that is unknown, of the wrong kind or out of its range."""


class ArrayError(Error, ValueError):
    """Arrays of the wrong shape, with values that are not numbers, or with times that do not increase."""


class FaultError(Error, ValueError):
    """A fault that is unknown, or that the log cannot have."""


class ModelError(Error):
    """A model that cannot be identified or must not be flown, or an autopilot that is not possible."""
