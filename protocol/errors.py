"""Every error that ommatidia raises on purpose, in one tree.

* OmmatidiaError
  x ConfigError          a configuration or calibration that cannot be used: names file, field and remedy
  x RecordingError       a recording that cannot be used: names file and field
  x LinkError            the bus cannot be opened, or the other side is not there
  x DecodeError          bytes from the network that are not a valid message: counted and dropped, never fatal
  x GeometryError        degenerate input to a geometric function
  x DriverError          a camera or wheel driver failed

The command line turns any of them into one line on stderr and exit code 2.
"""


class OmmatidiaError(Exception):
    """Base of all errors raised on purpose; its text is one clear line for a person."""


class ConfigError(OmmatidiaError):
    """A configuration or calibration cannot be used."""


class RecordingError(OmmatidiaError):
    """A recording cannot be used."""


class LinkError(OmmatidiaError):
    """The bus cannot be opened, or nobody answers on it."""


class DecodeError(OmmatidiaError):
    """Bytes from the network are not a valid message."""


class GeometryError(OmmatidiaError):
    """Degenerate input to a geometric function."""


class DriverError(OmmatidiaError):
    """A camera or wheel driver failed."""
