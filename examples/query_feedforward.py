"""Ask a running learner what to feed forward, with nothing but eclipse-zenoh."""

import json
import sys

import zenoh

config = zenoh.Config()
config.insert_json5("connect/endpoints", json.dumps(sys.argv[1:] or ["tcp/127.0.0.1:7448"]))
config.insert_json5("scouting/multicast/enabled", "false")
key = "tsd/hermes_lower/learner/feedforward?motion=squat;amplitude=0.05;frequency=0.25"
with zenoh.open(config) as session:
    for reply in session.get(key, timeout=10.0):
        print((reply.ok or reply.err).payload.to_string())
