"""Keys are filled in, read back, and refused where a name would change their meaning; the table has no slips."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocol import topics
from protocol.errors import ConfigError
from protocol.keys import Key

ENTRIES = [entry for entry in vars(topics).values() if isinstance(entry, Key)]


def test_a_key_lies_under_its_site() -> None:
    assert topics.LOCAL_MAP.full("lab", {"robot": "r1"}) == "ommatidia/lab/robot/r1/map"
    assert topics.POSES.full("lab", {}) == "ommatidia/lab/server/poses"


def test_a_name_left_out_of_a_pattern_stands_for_all() -> None:
    assert topics.LOCAL_MAP.pattern("lab", {}) == "ommatidia/lab/robot/*/map"


@given(st.from_regex(r"[a-z0-9][a-z0-9_-]{0,31}", fullmatch=True))
def test_names_are_read_back_from_a_full_key(name: str) -> None:
    assert topics.LOCAL_MAP.names(topics.LOCAL_MAP.full("lab", {"robot": name})) == {"robot": name}


@pytest.mark.parametrize("name", ["", "*", "**", "r1/map", "R1", "r 1", "r1\n", "ü", "x" * 33, "-r1", "$*"])
def test_a_name_that_would_change_the_key_is_refused(name: str) -> None:
    with pytest.raises(ConfigError, match="no name"):
        topics.LOCAL_MAP.pattern("lab", {"robot": name})
    with pytest.raises(ConfigError, match="site"):
        topics.POSES.full(name, {})


def test_a_missing_name_is_told() -> None:
    with pytest.raises(ConfigError, match=r"robot/\{robot\}/map needs a value for robot"):
        topics.LOCAL_MAP.full("lab", {})


def test_a_name_without_a_place_is_told() -> None:
    with pytest.raises(ConfigError, match="server/poses has no place for robot"):
        topics.POSES.full("lab", {"robot": "r1"})


def test_no_two_entries_share_a_key() -> None:
    templates = [entry.template for entry in ENTRIES]
    assert len(set(templates)) == len(templates) > 15
