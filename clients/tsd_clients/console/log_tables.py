"""Tables of logs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.markup import escape

from tsd_clients.console.run_tables import number_text
from tsd_clients.console.table import Column, console, print_table


def print_log(name: str, found: Mapping[str, Any]) -> None:
    """Print what ``summarize_log`` found: a line of what it is of, its measures, what went wrong.

    Args:
        name: Of the file.
    """
    for line in _lines(found):
        console.print(escape(line), highlight=False)
    errors = found["errors"]
    units = {f"m{error['unit']}": None for error in errors.values()}
    unit, rate = ", ".join(units), ", ".join(f"{each[1:]}/s²" for each in units)
    columns = [
        Column("axis", [escape(axis) for axis in errors], is_text=True),
        *(
            Column(f"{title}\n{unit}", [number_text(e[key], 1e3, 4) for e in errors.values()], rank)
            for title, key, rank in (
                ("RMS", "rms", 0),
                ("peak", "peak", 3),
                ("AC RMS", "ac_rms", 1),
                ("true RMS", "true_rms", 2),
            )
        ),
        Column(
            f"|fb|\n{rate}",
            [number_text(e["mean_abs_feedback"], 1.0, 5) for e in errors.values()],
            rank=4,
        ),
        Column(
            "", ["learned" if axis in found["learned"] else "" for axis in errors], 5, is_text=True
        ),
    ]
    print_table(name, columns)


def _lines(found: Mapping[str, Any]) -> list[str]:
    parameters = "".join(f" {name} {value:g}" for name, value in found["parameters"].items())
    what = f"{found['motion']}{parameters}" if found["motion"] else "a motion it does not name"
    lines = [
        f"{found['robot'] or 'a robot it does not name'}: {what}"
        + (f", feedforward {found['feedforward']}" if found["feedforward"] else "")
    ]
    if not found["ticks"]:
        return [*lines, "no tick"]
    lines.append(
        f"{found['ticks']} ticks from {found['from_s']:.3f} s to {found['to_s']:.3f} s, "
        f"{found['laps_run']} laps, {found['laps_measured']} of them measured"
    )
    if found["aborted"]:
        lines.append(f"aborted: {found['aborted']}")
    elif found["fell"]:
        lines.append("ended with a fall")
    elif found["steady"] is False:
        lines.append("never steady")
    lines += [f"veto: {veto}" for veto in found["vetoes"]]
    lines += [f"{count} ticks {status}" for status, count in found["failures"].items()]
    lines += [f"{count} periods missed, {why}" for why, count in found["missed"].items()]
    lines += [f"{joint} at its limit in {n} ticks" for joint, n in found["at_limits"].items()]
    times = found["tick_us"]
    if times["p50"] is not None:
        lines.append(f"tick {times['p50']:.0f} µs (p50), {times['p99']:.0f} µs (p99)")
    return lines
