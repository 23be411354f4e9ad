"""Haptics of large rigid-body worlds, in virtual time: the same bits as `tactus run --virtual-time`.

Session runs a scene, Scene is one, Tape reads a recorded run, Live watches a running controller. Units are SI and in the names; the frame is the world's,
z up, unless a name says otherwise; rotations are unit quaternions w, x, y, z. What is wrong is a tactus.Error with a
line that says what is accepted.
"""
from ._core import CheckedScene, Error, FileError, MachineError, OptionError, Replay, SavedState, SessionHand, Tape, UseError, __version__
from .live import Live
from .scene import Scene
from .session import Session

__all__ = ['CheckedScene', 'Error', 'FileError', 'Live', 'MachineError', 'OptionError', 'Replay', 'SavedState', 'Scene', 'Session',
           'SessionHand', 'Tape', 'UseError', '__version__']
