"""An MCAP file copied record by record, as far as it can be read."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable
from dataclasses import dataclass
from typing import BinaryIO

from mcap.exceptions import McapError
from mcap.records import Attachment, Channel, Chunk, Footer, McapRecord, Message, Metadata, Schema
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.writer import Writer

from tsd_casadi.wire.run_outline import RunOutline
from tsd_clients.logs.mcap_file import DESCRIPTION_TOPIC, METADATA, OUTLINE, SUMMARY, TICK_TOPIC
from tsd_clients.logs.run_summary import KILLED, metadata_of


@dataclass
class Copied:
    """What was copied.

    Attributes:
        ticks: How many.
        is_whole: Whether the file was read to its proper end.
        damaged: Chunks whose checksum was wrong, left out.
        read: Bytes of the file up to where it ends or cannot be understood.
        tells: Whether it says what the run was, so that there is something to show.
    """

    ticks: int = 0
    is_whole: bool = False
    damaged: int = 0
    read: int = 0
    tells: bool = False


def copy_mcap(
    source: BinaryIO,
    writer: Writer,
    span: tuple[int, int] | None = None,
    keeps: Callable[[str], bool] = lambda _: True,
) -> Copied:
    """Copy what can be read into a file that was begun, and finish that one.

    What lacks its end, because its writer was killed, gets one that says so.

    Args:
        source: At its beginning.
        writer: From ``begin_mcap``.
        span: Least and largest time of messages [ns since 1970]; all by default. The
            robot's description is moved to its beginning.
        keeps: Says by its name whether an attachment is copied.
    """
    copying = _Copying(writer, span, keeps)
    done = copying.copied
    records = StreamReader(source, emit_chunks=True).records
    try:
        for record in records:
            if isinstance(record, Chunk):
                copying.add_chunk(record)
            else:
                copying.add(record)
            done.read = source.tell()
            if isinstance(record, Footer):
                done.is_whole = True
    except (McapError, ValueError, struct.error):
        pass  # here it ends; what is behind has no beginning
    copying.finish()
    return done


class _Copying:
    def __init__(
        self, writer: Writer, span: tuple[int, int] | None, keeps: Callable[[str], bool]
    ) -> None:
        self.copied = Copied()
        self._writer, self._span, self._keeps = writer, span, keeps
        # by their numbers in the file that is read
        self._schemas: dict[int, int] = {}
        self._channels: dict[int, tuple[int, str]] = {}
        self._began, self._outline, self._summary = 0, b"", b""
        self._has_metadata = False

    def add_chunk(self, chunk: Chunk) -> None:
        try:
            records = breakup_chunk(chunk, validate_crc=True)
        except Exception:  # whatever a decompressor says of damaged bytes
            self.copied.damaged += 1
            return
        for record in records:
            self.add(record)

    def add(self, record: McapRecord) -> None:
        if isinstance(record, Schema):
            if record.id not in self._schemas:
                self._schemas[record.id] = self._writer.register_schema(
                    record.name, record.encoding, record.data
                )
        elif isinstance(record, Channel):
            if record.id not in self._channels and record.schema_id in self._schemas:
                number = self._writer.register_channel(
                    record.topic,
                    record.message_encoding,
                    self._schemas[record.schema_id],
                    record.metadata,
                )
                self._channels[record.id] = int(number), record.topic
        elif isinstance(record, Message):
            self._add_message(record)
        elif isinstance(record, Attachment):
            self._attach(record)
        elif isinstance(record, Metadata):
            self._has_metadata |= record.name == METADATA
            self._writer.add_metadata(record.name, record.metadata)

    def finish(self) -> None:
        self.copied.tells = bool(self._outline)
        if self._outline and not self._summary:
            end = json.dumps({"aborted": KILLED}).encode()
            self._writer.add_attachment(self._began, self._began, SUMMARY, "application/json", end)
        if self._outline and not self._has_metadata:
            summary = json.loads(self._summary or json.dumps({"aborted": KILLED}))
            outline = RunOutline.decode(self._outline)
            self._writer.add_metadata(METADATA, metadata_of(outline, summary))
        self._writer.finish()  # type: ignore[no-untyped-call]

    def _add_message(self, message: Message) -> None:
        if message.channel_id not in self._channels:
            return  # what it is stood in a damaged chunk
        channel, topic = self._channels[message.channel_id]
        time = message.log_time
        if self._span is not None:
            first, last = self._span
            if topic == DESCRIPTION_TOPIC:
                time = first
            elif not first <= time <= last:
                return
        self.copied.ticks += topic == TICK_TOPIC
        self._writer.add_message(
            channel,
            log_time=time,
            data=message.data,
            publish_time=max(time, message.publish_time),
            sequence=message.sequence,
        )

    def _attach(self, record: Attachment) -> None:
        if record.name == OUTLINE:
            self._began, self._outline = record.log_time, record.data
        if record.name == SUMMARY:
            self._summary = record.data
        if self._keeps(record.name):
            self._writer.add_attachment(
                record.create_time, record.log_time, record.name, record.media_type, record.data
            )
