"""Ask a running controller for one tick, with eclipse-zenoh and numpy alone.

This is all that a simulator or robot of your own has to do: read the layout
once from 'info', then pack state and command as docs/wire.md says. Usage:

    python own_simulator.py [ROBOT [ENDPOINT]]
"""

import json
import struct
import sys

import numpy as np
import zenoh

robot = sys.argv[1] if len(sys.argv) > 1 else "hermes_lower"
endpoint = sys.argv[2] if len(sys.argv) > 2 else "tcp/127.0.0.1:7447"

HEADER = struct.Struct("<4sHHQQQ")  # magic, version, kind, layout, sequence, instance


def ask(session: zenoh.Session, key: str, payload: bytes | None = None) -> bytes:
    """One query, one answer."""
    for reply in session.get(key, payload=payload, timeout=5.0):
        if reply.ok is not None:
            return reply.ok.payload.to_bytes()
        raise SystemExit(f"the controller refused: {reply.err.payload.to_string()}")
    raise SystemExit(f"nobody answered {key} at {endpoint}: is 'tsd controller' running?")


config = zenoh.Config()
config.insert_json5("connect/endpoints", json.dumps([endpoint]))
config.insert_json5("scouting/multicast/enabled", "false")
with zenoh.open(config) as session:
    info = json.loads(ask(session, f"tsd/{robot}/controller/info"))
    layout = int(info["layout_hash"], 16)
    request = {field["name"]: field for field in info["request"]}
    reply = {field["name"]: field for field in info["reply"]}

    # every field starts from its default: hold the home posture
    values = np.concatenate([field["default"] for field in info["request"]])
    # here goes your state: q, v in the order that info describes
    q = values[request["q"]["offset"] :][: request["q"]["size"]]
    q[2] -= 0.005  # the base 5 mm lower, as an example
    # here goes your reference: centre of mass 1 cm up
    values[request["com.reference"]["offset"] + 2] += 0.01

    message = HEADER.pack(b"TSDT", info["protocol"], 1, layout, 1, 0) + values.tobytes()
    answer = ask(session, f"tsd/{robot}/controller/tick", message)

magic, version, kind, layout_back, sequence, instance = HEADER.unpack_from(answer)
assert (magic, kind, layout_back, sequence) == (b"TSDT", 2, layout, 1)
numbers = np.frombuffer(answer, dtype="<f8", offset=HEADER.size)


def read(name: str) -> np.ndarray:
    """Take a field out of the reply."""
    return numbers[reply[name]["offset"] :][: reply[name]["size"]]


print(f"status {int(read('status')[0])} ({info['statuses'][str(int(read('status')[0]))]})")
for joint, torque in zip(info["joints"], read("tau"), strict=True):
    print(f"{joint:>6s} {torque:9.3f} N m")
