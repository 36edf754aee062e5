"""The services: a controller that answers ticks, a learner that keeps what was learned."""
