from __future__ import annotations

import json
import os
from typing import Any, Literal

import pytest
import zenoh

from tsd_casadi.wire.endpoints import CONTROLLER, LEARNER
from tsd_casadi.wire.session_settings import (
    ACCESS,
    RUNTIME,
    configure_runtime,
    merged,
    session_settings,
)

Service = Literal["controller", "learner", "run"] | None
SERVICES: tuple[Service, ...] = (None, "controller", "learner", "run")


@pytest.mark.parametrize("service", SERVICES)
def test_sessions_never_look_for_others_and_listen_only_where_told(service: Service) -> None:
    values = session_settings(listen=[CONTROLLER], service=service)
    assert values["scouting"]["multicast"]["enabled"] is False
    assert values["scouting"]["gossip"]["enabled"] is False
    assert values["listen"]["endpoints"] == [CONTROLLER]
    assert values["connect"]["endpoints"] == []
    assert values["transport"]["shared_memory"]["enabled"] is False
    assert session_settings()["listen"]["endpoints"] == []


@pytest.mark.parametrize("service", SERVICES)
def test_zenoh_takes_every_setting(service: Service) -> None:
    settings = session_settings(listen=[LEARNER], connect=[CONTROLLER], service=service)
    config = zenoh.Config.from_json5(json.dumps(settings))

    def check(part: Any, path: str) -> None:
        for name, value in part.items():
            if isinstance(value, dict):
                check(value, f"{path}{name}/")
            else:
                assert json.loads(config.get_json(f"{path}{name}")) is not None

    check(
        {
            name: settings[name]
            for name in ("scouting", "transport", "access_control")
            if name in settings
        },
        "",
    )


def test_services_take_in_queries_only_and_a_controller_waits_for_no_client() -> None:
    assert "access_control" not in session_settings()
    assert session_settings(service="learner")["access_control"] == ACCESS
    assert "qos" not in session_settings(service="learner")
    (rule,) = session_settings(service="controller")["qos"]["network"]
    assert rule["overwrite"] == {"congestion_control": "drop"}


def test_a_run_takes_in_subscribers_too_and_waits_for_none() -> None:
    settings = session_settings(service="run")
    (rule,) = settings["access_control"]["rules"]
    assert {*ACCESS["rules"][0]["messages"]} - {*rule["messages"]} == {"declare_subscriber"}
    assert settings["qos"] == session_settings(service="controller")["qos"]
    control = settings["transport"]["link"]["tx"]["queue"]["congestion_control"]
    assert control["drop"] == {"wait_before_drop": 0}


def test_settings_are_merged_by_field() -> None:
    before = {"a": {"b": 1, "c": [1, 2]}, "d": 2}
    assert merged(before, {"a": {"c": [3]}, "e": {"f": 4}}) == {
        "a": {"b": 1, "c": [3]},
        "d": 2,
        "e": {"f": 4},
    }
    assert before == {"a": {"b": 1, "c": [1, 2]}, "d": 2}
    assert merged({"a": {"b": 1}}, {"a": None}) == {"a": None}


@pytest.mark.parametrize("chosen", [None, "(rx:(worker_threads:3))"])
def test_the_users_choice_of_threads_is_kept(
    monkeypatch: pytest.MonkeyPatch, chosen: str | None
) -> None:
    monkeypatch.delenv("ZENOH_RUNTIME", raising=False)
    if chosen is not None:
        monkeypatch.setenv("ZENOH_RUNTIME", chosen)
    configure_runtime()
    assert os.environ["ZENOH_RUNTIME"] == (chosen or RUNTIME)
