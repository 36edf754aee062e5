"""The command 'tsd', and ``python -m tsd_cli``: nothing but the way in.

Ctrl-C prints no traceback at any moment. While modules load, and while the
interpreter ends, the signal itself ends the process; only while something is
open that has to be closed is it an exception (``tsd_cli.interrupt``).
"""

try:
    # before anything else
    import signal

    # a shell has it ignored in jobs that run in the background: then it stays ignored
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
except KeyboardInterrupt:
    raise SystemExit(130) from None


def main() -> None:
    """Run the command line."""
    # before numpy
    from tsd_casadi.single_thread import use_single_thread

    use_single_thread()
    from tsd_cli.command_line import run

    run()


if __name__ == "__main__":
    main()
