"""SIGINT and SIGTERM in the life of a service.

Until there is something to close, a signal ends the process at once and by
itself, whatever C code is running: ``end_at_once``. While a compiler runs it is
held back until the compiler is gone (``tsd_casadi.compilation.held_signals``).
While the service serves, the main thread sleeps in a read that any signal ends
(``tsd_server.stop_signals``). A second signal always ends the process at once.
"""

# this is the first module of a service: nothing else is imported before it has run
import signal

STOPPING = (signal.SIGINT, signal.SIGTERM)


def end_at_once() -> None:
    """Let SIGINT and SIGTERM end this process without any Python, from now on.

    To be called before anything heavy is imported: an exception in the middle of
    an import may end anywhere, and none is raised at all while C code runs for
    seconds. Signals that the parent had blocked or ignored count again.
    """
    for number in STOPPING:
        signal.signal(number, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, STOPPING)
