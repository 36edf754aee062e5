"""The services: a controller that answers ticks, a learner that keeps what was learned."""

import lazy_loader

# what is exported stands in __init__.pyi; nothing is imported before it is used
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
