"""Waits for what another process does. Nothing is judged by the clock; but no test waits for ever."""
import time

PATIENCE_S = 120


def wait_for(answer, what=""):
    """The first answer() that is true; `what` it is, for the message where none comes."""
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        value = answer()
        if value:
            return value
        time.sleep(0.02)
    raise AssertionError(f"no {what or answer} within {PATIENCE_S} s")
