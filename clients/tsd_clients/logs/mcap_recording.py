"""A repetition as messages of ROS 2, in an MCAP file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
from mcap.writer import Writer
from numpy.typing import NDArray

from tsd_casadi.robot.robot import Robot, load_robot
from tsd_casadi.state import Vector
from tsd_casadi.wire.run_outline import RunOutline
from tsd_clients.logs import mcap_file, ros_messages
from tsd_clients.logs.cdr import CdrMessage
from tsd_clients.logs.diagnostics import diagnose, diagnostic_array
from tsd_clients.logs.link_frames import LinkFrames, contact_frame
from tsd_clients.logs.mcap_file import McapFile
from tsd_clients.logs.run_summary import metadata_of
from tsd_clients.logs.tick_columns import column_sizes

# so often links are drawn [s], about as a screen does: all of them are most of a tick's bytes
LINK_PERIOD = 0.02
DIAGNOSTIC_PERIOD = 0.1  # s, as people read

Topic = tuple[int, CdrMessage]
Indices = NDArray[np.intp]


class McapRecording:
    """Writes what happens in a repetition into a file that was begun."""

    def __init__(self, writer: Writer, outline: RunOutline, began: int) -> None:
        """Write what is known before the first tick.

        Args:
            writer: From ``begin_mcap``.
            outline: What the repetition says of itself.
            began: When its time was 0 [ns since 1970].

        Raises:
            TsdError: If the robot's files cannot be used.
        """
        self._file, self._outline, self._began = McapFile(writer, began), outline, began
        self._known, self._vetoes = outline.known, list[str]()
        robot = load_robot(outline.robot_file)
        self._links = LinkFrames(robot)
        self._file.attach(mcap_file.OUTLINE, "application/json", outline.encode())
        self._describe(robot)
        kind, joints = "sensor_msgs/msg/JointState", self._known.joints
        self._measured = self._topic("/joint_states", kind, ros_messages.joint_state(joints))
        self._true = self._topic("/true/joint_states", kind, ros_messages.joint_state(joints))
        self._tf = self._topic(
            "/tf", "tf2_msgs/msg/TFMessage", ros_messages.transforms(self._links.names)
        )
        self._wrenches = [
            self._topic(
                f"/contacts/{contact}/wrench",
                "geometry_msgs/msg/WrenchStamped",
                ros_messages.wrench(contact_frame(contact)),
            )
            for contact in self._known.contacts
        ]
        self._diagnostics = self._file.add_topic(
            "/diagnostics", "diagnostic_msgs/msg/DiagnosticArray"
        )
        self._tick = self._topic(
            mcap_file.TICK_TOPIC, ros_messages.TICK, ros_messages.tick(column_sizes(outline))
        )
        self._next_links = self._next_diagnosis = 0.0
        self._undiagnosed: list[Mapping[str, Vector]] = []

    def add_settings(self, settings: bytes) -> None:
        """Attach how the run was set up, JSON."""
        self._file.attach(mcap_file.SETTINGS, "application/json", settings)

    def add_ticks(self, columns: Mapping[str, Vector]) -> None:
        """Write ticks.

        Args:
            columns: As of ``tick_columns``, at least one tick.
        """
        times = self._began + np.round(1e9 * columns["time"]).astype(np.int64)
        # exact in float64, too
        stamps = np.stack((times // 10**9, times % 10**9), axis=1).astype(float)
        waiting: list[tuple[int, int, bytes]] = []

        def add(topic: Topic, which: Indices, content: Mapping[str, Vector]) -> None:
            channel, message = topic
            if which.size:
                picked = {name: values[which] for name, values in content.items()}
                filled = message.fill(picked)
                waiting.extend(
                    (int(tick), channel, each) for tick, each in zip(which, filled, strict=True)
                )

        for topic, q, v in (
            (self._measured, columns["measured_q"], columns["measured_v"]),
            (self._true, columns["q"], columns["v"]),
        ):
            content = {"position": q[:, 7:], "velocity": v[:, 6:], "effort": columns["tau"]}
            add(topic, _known(q), {"stamp": stamps, **content})
        for topic, wrench in zip(
            self._wrenches, np.split(columns["wrenches"], len(self._wrenches), axis=1), strict=True
        ):
            add(topic, _known(wrench), {"stamp": stamps, "wrench": wrench})
        drawn = self._due(columns["time"])
        places = np.full((len(times), len(self._links.names), 7), np.nan)
        for tick in drawn:
            places[tick] = self._links.placements(columns["q"][tick])
        content = {f"stamp of {link}": stamps for link in range(places.shape[1])}
        content |= {f"placement of {link}": places[:, link] for link in range(places.shape[1])}
        add(self._tf, drawn, content)
        add(self._tick, np.arange(len(times)), {"stamp": stamps, **columns})
        for tick, channel, message in sorted(waiting, key=lambda each: each[0]):
            self._file.add_message(channel, int(times[tick]), message)
        self._diagnose(columns)

    def add_veto(self, veto: str) -> None:
        """Note why the feedforward is no longer in use."""
        self._vetoes.append(veto)

    def add_request(self, request: bytes) -> None:
        """Attach state and command of the first tick without a solution, float64."""
        self._file.attach(mcap_file.REQUEST, "application/octet-stream", request)

    def finish(self, summary: Mapping[str, Any]) -> None:
        """Write the end: what the run says of itself, and what makes the file whole.

        Args:
            summary: As of ``run_summary``.
        """
        if self._undiagnosed:
            self._write_diagnosis()
        self._file.attach(mcap_file.SUMMARY, "application/json", json.dumps(summary).encode())
        self._file.finish(metadata_of(self._outline, summary))

    def _due(self, time: Vector) -> Indices:
        due = []
        for tick, moment in enumerate(time):
            # half a period: LINK_PERIOD need not be a multiple of it
            if moment >= self._next_links - 0.5 * self._outline.period:
                due.append(tick)
                self._next_links = max(self._next_links, moment - LINK_PERIOD) + LINK_PERIOD
        return np.array(due, dtype=np.intp)

    def _diagnose(self, columns: Mapping[str, Vector]) -> None:
        start = 0
        for tick, moment in enumerate(columns["time"]):
            if moment >= self._next_diagnosis:
                self._keep(columns, start, tick)
                if self._undiagnosed:
                    self._write_diagnosis()
                self._next_diagnosis, start = moment + DIAGNOSTIC_PERIOD, tick
        self._keep(columns, start, len(columns["time"]))

    def _keep(self, columns: Mapping[str, Vector], start: int, stop: int) -> None:
        if stop > start:
            self._undiagnosed.append({name: each[start:stop] for name, each in columns.items()})

    def _write_diagnosis(self) -> None:
        parts, self._undiagnosed = self._undiagnosed, []
        names = ("time", "lap", "share", "missed", "status", "active", "joint_limits")
        columns = {name: np.concatenate([part[name] for part in parts]) for name in names}
        time = self._began + round(1e9 * float(columns["time"][-1]))
        diagnoses = diagnose(columns, self._known, self._vetoes)
        message = diagnostic_array(divmod(time, 10**9), diagnoses, self._outline.robot)
        self._file.add_message(self._diagnostics, time, message)

    def _describe(self, robot: Robot) -> None:
        described = robot.bodies.description
        name = "robot.urdf" if described.kind == "urdf" else "robot.xml"
        self._file.attach(name, "application/xml", described.text.encode())
        self._file.attach("robot.yaml", "application/yaml", robot.path.read_bytes())
        if described.kind == "urdf":
            channel = self._file.add_topic(
                mcap_file.DESCRIPTION_TOPIC, "std_msgs/msg/String", mcap_file.KEPT
            )
            self._file.add_message(channel, self._began, ros_messages.string(described.text))

    def _topic(self, topic: str, kind: str, message: CdrMessage) -> Topic:
        return self._file.add_topic(topic, kind), message


def _known(values: Vector) -> Indices:
    """Find the ticks whose values are known."""
    return np.flatnonzero(~np.isnan(values[:, 0]))
