"""How far many units are."""
import sys
import time


class Progress:
    """On a terminal a line that moves, from 2 s on."""

    def __init__(self, count):
        self.count, self.done, self.began, self.last = count, 0, time.monotonic(), 0.0

    def advance(self):
        self.done += 1
        elapsed = time.monotonic() - self.began
        if sys.stderr.isatty() and elapsed > 2 and elapsed - self.last > 0.5:
            self.last = elapsed
            left_s = elapsed / self.done * (self.count - self.done)
            print(f'\r\033[K{self.done} of {self.count} units, {left_s:.0f} s left', end='', file=sys.stderr)

    def end(self):
        if self.last:
            print('\r\033[K', end='', file=sys.stderr)
