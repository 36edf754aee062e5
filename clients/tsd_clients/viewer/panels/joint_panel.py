"""What every joint does, and which limits bind."""

from __future__ import annotations

from html import escape

import numpy as np
import viser

from tsd_casadi.tick.row_state import NO_INEQUALITY, RowState, name_row
from tsd_clients.viewer.panel import Panel
from tsd_clients.viewer.panels.run_panel import RunPanel
from tsd_clients.viewer.shown_run import RunLabel
from tsd_clients.viewer.ticks import Ticks

# numbers that change faster than this cannot be read [s]
PERIOD = 0.2
# shares of a limit from which on a bar warns, and is nearly at its end
BUSY, FULL = 0.6, 0.9
CALM_COLOR, BUSY_COLOR, FULL_COLOR = "#4dabf7", "#fab005", "#e03131"
TABLE = "<table style='font-size:12px;width:100%;padding:0 8px;border-spacing:0'>"
CELL = "style='padding:0 6px;text-align:right;font-variant-numeric:tabular-nums'"


class JointPanel(Panel):
    """Angles, torques as shares of their limits, and the limits that are active."""

    title = "Joints"

    def __init__(self, runs: RunPanel) -> None:
        """Show the chosen run."""
        self._runs = runs
        self._written = float("-inf")

    def build(self, server: viser.ViserServer) -> None:
        """Add the tables."""
        with server.gui.add_folder("active limits"):
            self._limits = server.gui.add_html("")
        with server.gui.add_folder("torques"):
            self._joints = server.gui.add_html("")

    def update(self, now: float) -> None:
        """Write the newest numbers."""
        run = self._runs.chosen
        if run is None or now < self._written + PERIOD:
            return
        ticks = run.ticks
        if not len(ticks):
            return
        self._written = now
        self._limits.content = limits_table(run.label, ticks)
        self._joints.content = joints_table(run.label, ticks)


def joints_table(label: RunLabel, ticks: Ticks) -> str:
    """Write a line for each joint: its angle, its torque and the share of its limit."""
    largest = np.abs(ticks.tau).max(axis=0)
    rows = [
        f"<tr><td>{escape(joint)}</td><td data-angle='{escape(joint)}' {CELL}>{angle:.3f}</td>"
        f"<td {CELL}>{torque:.1f}</td><td style='width:100%'>{_bar(torque, peak, limit)}</td></tr>"
        for joint, angle, torque, peak, limit in zip(
            label.joints,
            ticks.q[-1, 7:],
            ticks.tau[-1],
            largest,
            label.torque_limits,
            strict=True,
        )
    ]
    head = (
        f"<tr style='color:#868e96'><td>joint</td><td {CELL}>rad</td><td {CELL}>N&thinsp;m</td>"
        "<td>share of the limit</td></tr>"
    )
    return f"{TABLE}{head}{''.join(rows)}</table>"


def limits_table(label: RunLabel, ticks: Ticks) -> str:
    """Write a line for each limit that was active in the last seconds, the most active first."""
    states = np.abs(ticks.bounds).astype(int)
    active = ~np.isin(states, NO_INEQUALITY)
    shares = active.mean(axis=0)
    rows = []
    for place in sorted(np.flatnonzero(shares), key=lambda place: -shares[place]):
        now = bool(active[-1, place])
        newest = int(states[np.flatnonzero(active[:, place])[-1], place])
        name = name_row(label.limit_rows[place], RowState(newest))
        weight, word = ("600", "now") if now else ("400", "")
        rows.append(
            f"<tr style='font-weight:{weight}'><td data-limit='{escape(name)}'>{escape(name)}</td>"
            f"<td {CELL}>{100 * shares[place]:.0f} %</td><td {CELL}>{word}</td></tr>"
        )
    if not rows:
        return "<p style='font-size:12px;margin:4px 10px'>None in the last seconds.</p>"
    return f"{TABLE}{''.join(rows)}</table>"


def _bar(torque: float, peak: float, limit: float) -> str:
    """Draw the share of a limit, and how far it went in the last seconds."""
    share, most = (min(1.0, abs(value) / limit) for value in (torque, peak))
    color = FULL_COLOR if share >= FULL else BUSY_COLOR if share >= BUSY else CALM_COLOR
    return (
        "<div style='position:relative;height:9px;background:#e9ecef;border-radius:2px'>"
        f"<div style='height:9px;width:{100 * share:.1f}%;background:{color};border-radius:2px'>"
        f"</div><div style='position:absolute;top:0;left:{100 * most:.1f}%;width:2px;height:9px;"
        "background:#495057'></div></div>"
    )
