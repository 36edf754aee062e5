"""A file of ROS 2 messages while it is written, and the names in one of ours."""

from __future__ import annotations

from collections.abc import Mapping
from typing import BinaryIO

from mcap.writer import CompressionType, Writer

from tsd_casadi.version import __version__
from tsd_clients.logs.ros_messages import DEFINITIONS

# bytes before compression: about ten ticks, which are lost if the writer is killed
CHUNK_SIZE = 65536
LIBRARY = f"tsd_casadi {__version__}"
TICK_TOPIC = "/tsd/tick"
DESCRIPTION_TOPIC = "/robot_description"
OUTLINE, SETTINGS, SUMMARY = "outline.json", "settings.json", "summary.json"
REQUEST = "infeasible_request.float64"
METADATA = "tsd"
# a player sends such a message also to who listens later; every field is asked for
KEPT = """\
- history: keep_last
  depth: 1
  reliability: reliable
  durability: transient_local
  deadline: {sec: 9223372036, nsec: 854775807}
  lifespan: {sec: 9223372036, nsec: 854775807}
  liveliness: automatic
  liveliness_lease_duration: {sec: 9223372036, nsec: 854775807}
  avoid_ros_namespace_conventions: false
"""


def begin_mcap(file: BinaryIO) -> Writer:
    """Begin a file that the tools of ROS 2 read: small chunks, each with its checksum."""
    writer = Writer(file, chunk_size=CHUNK_SIZE, compression=CompressionType.ZSTD)
    writer.start(profile="ros2", library=LIBRARY)
    return writer


class McapFile:
    """Topics, messages and attachments of a file that was begun."""

    def __init__(self, writer: Writer, began: int) -> None:
        """Go on behind what is there.

        Args:
            writer: From ``begin_mcap``.
            began: Time of the attachments [ns since 1970].
        """
        self._writer, self._began = writer, began
        self._schemas: dict[str, int] = {}

    def add_topic(self, topic: str, kind: str, quality: str = "") -> int:
        """Declare a topic.

        Args:
            kind: Type of its messages, one of ``DEFINITIONS``.
            quality: Its offered QoS profiles as rosbag2 writes them.

        Returns:
            Its channel.
        """
        if kind not in self._schemas:
            definition = DEFINITIONS[kind].encode()
            self._schemas[kind] = self._writer.register_schema(kind, "ros2msg", definition)
        metadata = {"offered_qos_profiles": quality}
        return int(self._writer.register_channel(topic, "cdr", self._schemas[kind], metadata))

    def add_message(self, channel: int, time: int, message: bytes) -> None:
        """Write a message.

        Args:
            time: [ns since 1970].
        """
        self._writer.add_message(channel, log_time=time, data=message, publish_time=time)

    def attach(self, name: str, kind: str, content: bytes) -> None:
        """Attach a document.

        Args:
            kind: Its media type.
        """
        self._writer.add_attachment(self._began, self._began, name, kind, content)

    def finish(self, metadata: Mapping[str, str]) -> None:
        """Write what makes the file whole."""
        self._writer.add_metadata(METADATA, dict(metadata))
        self._writer.finish()  # type: ignore[no-untyped-call]
