"""A running controller, watched."""
import json
import os

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

    def state(self):
        """What the run says of itself now, a dict: verdict, pacing, faults, and its fault's tape. Empty before the first."""
        text = self._state()
        return json.loads(text) if text else {}

    def request(self, line):
        """A request of `tactus control` (state, arm, rearm, disarm, reset, stop, pause, play, tick, cycle, pace X); returns
        the answer as a dict. A refusal is a UseError."""
        if '\n' in line:
            raise _core.OptionError('Live: a request of several lines; accepted: one')
        try:
            answer = json.loads(self._ask(line))
        except json.JSONDecodeError as error:
            raise _core.MachineError('Live: the answer of the run is no JSON') from error
        if not answer.get('ok', True):
            raise _core.UseError('Live: ' + answer.get('said', 'refused'))
        return answer

    def take_hand(self):
        """Takes the hand of a simulated device, from where it is: the scene's script leads it no more."""
        self.request(f'hand {os.getpid()} take')

    def lead_hand(self, moved_m, turned_rad=(0, 0, 0)):
        """Leads the hand that was taken to this far from where it was taken: (3,) m and a rotation vector (3,) rad, in the
        device's frame. The run limits its speed; after 0.2 s of silence the hand holds, and somebody else may take it."""
        self.request(f'hand {os.getpid()} ' + ' '.join(f'{float(x):.6f}' for x in (*moved_m, *turned_rad)))

    def rest_hand(self):
        """Lets the hand rest where its script has it."""
        self.request(f'hand {os.getpid()} rest')

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self.close()
