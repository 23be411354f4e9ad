from collections.abc import Callable, Sequence
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import SceneLike, Session

Observation = dict[str, NDArray[np.float64]]


class TouchEnv(gymnasium.Env[Observation, NDArray[np.float64]]):
    session: Session
    def __init__(self, scene: SceneLike, *, watch: Sequence[str | int] = (),
                 reward: Callable[[Observation, NDArray[np.float64], dict[str, Any]], tuple[float, bool]] | None = None,
                 vary: Callable[[np.random.Generator], SceneLike] | None = None, ticks: int = 10,
                 speed_m_per_s: float = 0.2, turn_rad_per_s: float | None = None, reach_m: float = 0.1,
                 duration_s: float = 10.0, **options: Any) -> None: ...
    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Observation, dict[str, Any]]: ...
    def step(self, action: ArrayLike) -> tuple[Observation, float, bool, bool, dict[str, Any]]: ...
    def close(self) -> None: ...
