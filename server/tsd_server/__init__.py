"""The services: a controller that answers ticks, a learner that keeps what was learned."""


def __getattr__(name: str) -> object:
    # not imported at once: ``python -m tsd_server`` comes through here before its own
    # first statement, which is the one that decides what Ctrl-C does
    import lazy_loader

    # what is exported stands in __init__.pyi; nothing is imported before it is used
    get, _, names = lazy_loader.attach_stub(__name__, __file__)
    return names if name == "__all__" else get(name)


def __dir__() -> list[str]:
    return list(__getattr__("__all__"))  # type: ignore[call-overload]
