"""Keys of the bus: templates such as `robot/{robot}/map`, filled in under one site, and read back."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

from protocol.errors import ConfigError

ROOT = "ommatidia"
ANY = "*"

_NAME = re.compile(r"[a-z0-9][a-z0-9_-]{0,31}")


@dataclass(frozen=True)
class Key:
    """A key below the site, with a placeholder in braces for each name that it carries."""

    template: str

    @property
    def placeholders(self) -> tuple[str, ...]:
        """Return the names to be filled in, in their order."""
        return tuple(part[1:-1] for part in self.template.split("/") if part.startswith("{"))

    def full(self, site: str, names: Mapping[str, str]) -> str:
        """Return the full key. Raises ConfigError where a name is missing, unknown or unusable."""
        if missing := [name for name in self.placeholders if name not in names]:
            raise ConfigError(f"{self.template} needs a value for {', '.join(missing)}")
        return self.pattern(site, names)

    def pattern(self, site: str, names: Mapping[str, str]) -> str:
        """Return the full key with `*` for each name left out. Raises ConfigError where a name is unknown or unusable."""
        if unknown := names.keys() - set(self.placeholders):
            raise ConfigError(f"{self.template} has no place for {', '.join(sorted(unknown))}")
        for what, name in (("site", site), *names.items()):
            if not _NAME.fullmatch(name):
                raise ConfigError(f"{what} {name!r} is no name: use 1 to 32 of a-z, 0-9, '_' and '-', starting with a letter or digit")
        parts = (names.get(part[1:-1], ANY) if part.startswith("{") else part for part in self.template.split("/"))
        return "/".join((ROOT, site, *parts))

    def names(self, full_key: str) -> dict[str, str]:
        """Return the names that a full key, which this key's pattern matched, carries."""
        pairs = zip(self.template.split("/"), full_key.split("/")[2:], strict=True)
        return {part[1:-1]: name for part, name in pairs if part.startswith("{")}
