"""Gymnasium's interface on a session: an agent leads the hand. Needs the package gymnasium, which nothing else does."""
import numpy as np

from ._core import MachineError, OptionError
from .session import Session

try:
    import gymnasium
except ImportError as error:
    raise MachineError('tactus.gym: the package gymnasium is missing; accepted: one that this Python imports') from error


def _turned(rotation, by_rad):
    """The unit quaternion (4,) w x y z turned by a rotation vector (3,), rad, world frame."""
    angle = np.linalg.norm(by_rad)
    half = np.array([1.0, 0, 0, 0]) if angle == 0 else np.concatenate([[np.cos(angle / 2)], np.sin(angle / 2) / angle * by_rad])
    w, v = half[0], half[1:]
    product = np.concatenate([[w * rotation[0] - v @ rotation[1:]], w * rotation[1:] + rotation[0] * v + np.cross(v, rotation[1:])])
    return product / np.linalg.norm(product)


class TouchEnv(gymnasium.Env):
    """An environment of Gymnasium: the agent moves the target of the simulated hand, and sees what the hand feels.

    action: (3,) in -1 to 1, the target's velocity as a share of speed_m_per_s, world frame; with turn_rad_per_s (6,), the
    last three its angular velocity. The target stays within reach_m of its start, on each axis: what it holds lags behind,
    as a hand does. Each step is `ticks` ticks.

    observation, float64, SI, world frame unless said otherwise, poses as x y z w x y z: target (7,), where the hand wants
    the tool; tool (7,), where the device has it; proxy (7,) and proxy_velocity (6,), of its centre of mass and principal
    axes, which the device holds; force (6,), on the hand, N and N m, device frame, the mean of the step's ticks; bodies
    (len(watch), 7), those of `watch`, by name or number, of the frames that the scene places.

    reward: a function reward(observation, action, info) that returns the reward and whether the episode has reached its
    end; None: 0 and never. vary: a function vary(random) that returns the scene of the next episode, with the seeded
    generator of reset(); None: each is `scene`. An episode is truncated after duration_s, and terminated by a fault, whose
    number is info['fault']. options: those of Session. Same seed and actions, same bits.
    """

    metadata = {'render_modes': []}

    def __init__(self, scene, *, watch=(), reward=None, vary=None, ticks=10, speed_m_per_s=0.2, turn_rad_per_s=None,
                 reach_m=0.1, duration_s=10.0, **options):
        for name, value in (('ticks', ticks), ('speed_m_per_s', speed_m_per_s), ('reach_m', reach_m), ('duration_s', duration_s)):
            if not value > 0:
                raise OptionError(f'TouchEnv: {name}={value!r:.64}; accepted: a number > 0')
        if turn_rad_per_s is not None and not turn_rad_per_s > 0:
            raise OptionError(f'TouchEnv: turn_rad_per_s={turn_rad_per_s!r:.64}; accepted: a number > 0, or None')
        if ticks != int(ticks):
            raise OptionError(f'TouchEnv: ticks={ticks!r:.64}; accepted: a whole number of ticks a step')
        self._reward, self._vary, self._ticks, self._reach_m, self._duration_s = reward, vary, int(ticks), reach_m, duration_s
        self._watch, self._options = list(watch), options
        self.session = Session(scene, hand='targets', **options)
        self._watched = self._numbers()
        turns = [] if turn_rad_per_s is None else [turn_rad_per_s] * 3
        self._rate = np.array([speed_m_per_s] * 3 + turns, dtype=float)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (len(self._rate),), np.float64)

        def anything(*shape):
            return gymnasium.spaces.Box(-np.inf, np.inf, shape, np.float64)

        self.observation_space = gymnasium.spaces.Dict({
            'target': anything(7), 'tool': anything(7), 'proxy': anything(7), 'proxy_velocity': anything(6),
            'force': anything(6), 'bodies': anything(len(self._watched), 7)})
        self._begin()

    def reset(self, *, seed=None, options=None):
        """Begins an episode; returns (observation, info)."""
        super().reset(seed=seed)
        if self._vary is None:
            self.session.reset()
        else:
            self.session.replace(self._vary(self.np_random), hand='targets', **self._options)
            self._watched = self._numbers()
        self._begin()
        return self._observe(self.session.look()), self._info()

    def step(self, action):
        """Moves the target for `ticks` ticks; returns (observation, reward, terminated, truncated, info)."""
        action = np.clip(np.asarray(action, dtype=float), -1, 1)
        if action.shape != self._rate.shape or not np.all(np.isfinite(action)):
            raise OptionError(f'TouchEnv: an action of shape {action.shape}; accepted: {self._rate.shape}, finite')
        moved = action * self._rate * self.session.period_s
        targets = np.empty((self._ticks, 7))
        for target in targets:
            self._target[:3] = np.clip(self._target[:3] + moved[:3], self._start - self._reach_m, self._start + self._reach_m)
            if len(moved) == 6:
                self._target[3:] = _turned(self._target[3:], moved[3:])
            target[:] = self._target
        self.session.step(targets)
        observation, info = self._observe(self.session.look()), self._info()
        reward, reached = (0.0, False) if self._reward is None else self._reward(observation, action, info)
        terminated = bool(reached) or info['fault'] != 0
        return observation, float(reward), terminated, bool(self.session.time_s >= self._duration_s), info

    def close(self):
        """Ends the session."""
        self.session.close()

    def _numbers(self):
        names = [body['name'] for body in self.session.bodies]
        numbers = []
        for body in self._watch:
            if isinstance(body, str) and body in names:
                numbers.append(names.index(body))
            elif isinstance(body, (int, np.integer)) and 0 <= body < len(names):
                numbers.append(int(body))
            else:
                raise OptionError(f'TouchEnv: watch: {body!r:.64} is no body of the scene; accepted: a name, or a number below {len(names)}')
        return np.array(numbers, dtype=int)

    def _begin(self):
        # One tick, in which the device says where it is: that is where the target starts.
        self.session.step(1)
        self._target = self._tool()
        self._start = self._target[:3].copy()

    def _tool(self):
        # Where the device holds the tool is where it wants the proxy: a session calls that its target.
        last = self.session.last
        return np.concatenate([last['target_position_m'], last['target_rotation']])

    def _observe(self, ticks):
        last = self.session.last
        return {
            'target': self._target.copy(),
            'tool': self._tool(),
            'proxy': np.concatenate([last['proxy_position_m'], last['proxy_rotation']]),
            'proxy_velocity': np.concatenate([last['proxy_velocity_m_per_s'], last['proxy_angular_velocity_rad_per_s']]),
            'force': np.concatenate([ticks['force_N'].mean(axis=0), ticks['torque_Nm'].mean(axis=0)]),
            'bodies': np.concatenate([self.session.position[self._watched], self.session.rotation[self._watched]], axis=1)}

    def _info(self):
        return {'time_s': self.session.time_s, 'fault': int(self.session.last['fault'])}
