"""A running controller, watched."""
import json
import secrets

from . import _core


class Live(_core.Live):
    """A running controller (`tactus run --control SOCKET`, or the service), watched read-only through its shared memory.

    look() gives the ticks since the last look, frame() the bodies. The controller publishes both from its normal side; its
    haptic thread waits for nobody. Who may watch, the socket's owner decides. One thread.

    Closing, or the end of this process, ends the watching and not the run. A run that is over is `ended`; the last look
    still gives what it had written.
    """

    def __init__(self, socket='/run/tactus/control'):
        super().__init__(socket)
        self._hand = secrets.randbelow(2**63) + 1  # who asks for the hand

    def state(self):
        """What the run says of itself now, a dict: verdict, pacing, faults, and its fault's tape. Empty before the first."""
        text = self._state()
        return json.loads(text) if text else {}

    def request(self, line):
        """A request of `tactus control` (state, arm, rearm, disarm, reset, stop, pause, play, tick, cycle, pace X); returns
        the answer as a dict. A refusal is a UseError."""
        if not isinstance(line, str):
            raise _core.OptionError(f'Live: request: {line!r:.64}; accepted: text')
        if '\n' in line:
            raise _core.OptionError('Live: a request of several lines; accepted: one')
        try:
            answer = json.loads(self._ask(line.encode(errors='replace').decode()))
        except json.JSONDecodeError as error:
            raise _core.MachineError('Live: the answer of the run is no JSON') from error
        if not answer.get('ok', True):
            raise _core.UseError('Live: ' + answer.get('said', 'refused'))
        return answer

    def take_hand(self):
        """Takes the hand of a simulated device, from where it is: the scene's script leads it no more."""
        self.request(f'hand {self._hand} take')

    def lead_hand(self, moved_m, turned_rad=(0, 0, 0)):
        """Leads the hand that was taken to this far from where it was taken: (3,) m and a rotation vector (3,) rad, in the
        device's frame. The run limits its speed; after 0.2 s of silence the hand holds, and somebody else may take it."""
        try:
            wish = [float(x) for x in (*moved_m, *turned_rad)]
        except (TypeError, ValueError):
            wish = []
        if len(wish) != 6:
            raise _core.OptionError(f'Live: lead_hand: {moved_m!r:.64}, {turned_rad!r:.64}; accepted: 3 and 3 numbers')
        self.request(f'hand {self._hand} ' + ' '.join(f'{x:.6f}' for x in wish))

    def rest_hand(self):
        """Lets the hand rest where its script has it."""
        self.request(f'hand {self._hand} rest')

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self.close()
