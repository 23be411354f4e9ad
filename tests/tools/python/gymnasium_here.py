"""Gymnasium; or, where it is missing, as in Debian, a stand-in with the few parts that tactus.gym uses."""
import sys
import types

import numpy as np

HAS_GYMNASIUM = True
try:
    import gymnasium
except ImportError:
    HAS_GYMNASIUM = False
    gymnasium = types.ModuleType("gymnasium")

    class Env:
        def reset(self, *, seed=None, options=None):
            if seed is not None or not hasattr(self, "np_random"):
                self.np_random = np.random.default_rng(seed)

    class Box:
        def __init__(self, low, high, shape, dtype):
            self.low, self.high, self.shape, self.dtype = low, high, shape, dtype

        def contains(self, x):
            return x.shape == self.shape and x.dtype == self.dtype and bool(np.all((x >= self.low) & (x <= self.high)))

    class Dict:
        def __init__(self, spaces):
            self.spaces = spaces

        def contains(self, x):
            return x.keys() == self.spaces.keys() and all(space.contains(x[key]) for key, space in self.spaces.items())

    gymnasium.Env = Env
    gymnasium.spaces = types.SimpleNamespace(Box=Box, Dict=Dict)
    sys.modules["gymnasium"] = gymnasium
