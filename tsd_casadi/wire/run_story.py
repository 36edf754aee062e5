"""How a story is put together of events that are written already."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

STORY: Final = "tsd.run-story/1"


def join_story(events: Sequence[bytes]) -> bytes:
    """Put the message ``RunStory`` together of encoded events, without reading them again."""
    return b'{"format":"%b","events":[%b]}' % (STORY.encode(), b",".join(events))
