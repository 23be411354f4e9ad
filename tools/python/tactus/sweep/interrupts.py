"""What interrupts a sweep or the parts of an experiment: Ctrl-C, SIGTERM, and SIGHUP, the end of the terminal."""
import signal

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def raise_once():
    """From now on the first of them raises KeyboardInterrupt in the main thread; those after it do not disturb the end."""
    def interrupted(_number, _frame):
        for number in SIGNALS:
            signal.signal(number, signal.SIG_IGN)
        raise KeyboardInterrupt

    for number in SIGNALS:
        if signal.getsignal(number) is not signal.SIG_IGN:  # as under nohup
            signal.signal(number, interrupted)
