"""Learning environments: an operation with reset() and step(), with the results that Gymnasium defines.

Gymnasium is optional: with it, the spaces are its boxes, and the environment may be wrapped as any other.

    env = SurgeryEnv(Pocket())
    observation, info = env.reset(seed=1)
    observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
"""

from __future__ import annotations

import importlib
import importlib.util
from typing import Any, Optional, Protocol, Union

import numpy as np
from numpy.typing import NDArray

from ._core import Hand, Operation, Scan, Touches

Array = NDArray[np.float64]


class Box:
    """An axis-aligned box of float32 numbers: the part of gymnasium.spaces.Box that an environment needs."""

    def __init__(self, low: NDArray[np.float32], high: NDArray[np.float32]) -> None:
        self.low, self.high = low, high
        self.shape, self.dtype = low.shape, low.dtype
        self._random = np.random.default_rng()

    def seed(self, seed: Optional[int] = None) -> None:
        self._random = np.random.default_rng(seed)

    def sample(self) -> NDArray[np.float32]:
        sample: NDArray[np.float32] = self._random.uniform(self.low, self.high).astype(np.float32)
        return sample

    def contains(self, value: Any) -> bool:
        array = np.asarray(value)
        return array.shape == self.shape and bool((array >= self.low).all() and (array <= self.high).all())


def _box(low: Any, high: Any) -> Any:
    low, high = np.asarray(low, np.float32), np.asarray(high, np.float32)
    if importlib.util.find_spec("gymnasium") is None:
        return Box(low, high)
    return importlib.import_module("gymnasium.spaces").Box(low, high, dtype=np.float32)


class Task(Protocol):
    """What is to be done: the operation, the start of the tool, and the reward."""

    def open(self) -> Operation:
        """Opens the operation, with one hand that holds a burr."""

    def start(self, random: np.random.Generator) -> Array:
        """Returns the position at which an episode starts, mm."""

    def goal(self) -> Array:
        """Returns the point to which positions in observations are relative, mm."""

    def judge(self, operation: Operation, touches: Optional[Touches]) -> tuple[float, bool, dict[str, float]]:
        """Returns the value of the state, whether the task is done, and facts for `info`. The reward of a step
        is the growth of the value. `touches`: of the last step; None at the start."""


class Pocket:
    """A pocket is drilled: bone within a ball is removed, and none outside.

    The value is the removed share of the bone in the ball, minus the removed volume outside, relative to the
    same bone. Done at 90 %.
    """

    def __init__(self, scan: Optional[Scan] = None, centre: Any = (0.0, 0.0, 28.0), radius: float = 4.0,
                 iso: float = 300.0, burr_diameter: float = 3.0) -> None:
        self.scan = scan if scan is not None else Scan.phantom("sphere", spacing=(1, 1, 1), radius=30)
        self.centre, self.radius, self.iso = np.asarray(centre, float), float(radius), float(iso)
        self.burr_diameter = float(burr_diameter)
        around = self.centre + self.radius * np.array([[-1.0], [1.0]])
        voxels = self.scan.voxel(around)
        low = np.maximum(np.floor(voxels.min(axis=0)), 0).astype(int)
        high = np.minimum(np.ceil(voxels.max(axis=0)), np.array(self.scan.shape[::-1]) - 1).astype(int)
        self._low, self._high = low.tolist(), high.tolist()
        z, y, x = np.mgrid[low[2] : high[2] + 1, low[1] : high[1] + 1, low[0] : high[0] + 1]
        points = np.stack([x, y, z], axis=-1).reshape(-1, 3).astype(float)
        before = self.scan.array[low[2] : high[2] + 1, low[1] : high[1] + 1, low[0] : high[0] + 1]
        distance = np.linalg.norm(self.scan.world(points) - self.centre, axis=1)
        inside = (distance <= self.radius).reshape(before.shape) & (before >= self.iso)
        self._before = before[inside].astype(float)
        self._inside = inside
        self._voxel = abs(float(np.linalg.det(self.scan.world(np.eye(3)) - self.scan.world(np.zeros((3, 3))))))
        self.bone_mm3 = self._voxel * len(self._before)
        if self.bone_mm3 <= 0:
            raise ValueError("The ball contains no bone. Move the centre, or lower iso.")

    def open(self) -> Operation:
        hand = Hand("burr", diameter=self.burr_diameter, removal_rate=200)
        return Operation.open(self.scan, hand=hand, iso=self.iso)

    def start(self, random: np.random.Generator) -> Array:
        start: Array = self.centre + np.array([*random.uniform(-2, 2, 2), self.radius + 6.0])
        return start

    def goal(self) -> Array:
        return self.centre

    def judge(self, operation: Operation, touches: Optional[Touches]) -> tuple[float, bool, dict[str, float]]:
        now = operation.read(self._low, self._high)[self._inside].astype(float)
        # A voxel approaches air in proportion to its removed share.
        inside = self._voxel * float(np.sum((self._before - now) / (self._before + 1000.0)))
        outside = max(operation.removed_mm3 - inside, 0.0)
        share = inside / self.bone_mm3
        return share - outside / self.bone_mm3, share >= 0.9, {"removed_share": share, "outside_mm3": outside}


class BurrHole:
    """A hole is drilled through the built-in head to the dura, which must stay whole.

    The value is the removed share of the bone between the entry and the dura, along a vertical line, minus 2 if
    the dura was torn. Done when no bone is left, or the dura is torn.
    """

    def __init__(self, entry: Any = (15.0, -20.0), burr_diameter: float = 4.0) -> None:
        scan = Scan.phantom("head")
        self.burr_diameter = float(burr_diameter)
        x, y, _ = np.rint(scan.voxel([[entry[0], entry[1], 0.0]])[0]).astype(int).tolist()
        column = scan.array[:, y, x]
        bone = np.flatnonzero(column >= 300)
        if len(bone) == 0:
            raise ValueError("No bone above the entry. Choose another entry.")
        top = int(bone[-1])
        bottom = top
        while bottom > 0 and column[bottom - 1] >= 300:
            bottom -= 1
        self._low, self._high = [x, y, bottom], [x, y, top]
        self._before = column[bottom : top + 1].astype(float)
        self.entry: Array = scan.world([[x, y, top]])[0]
        self._tears = 0

    def open(self) -> Operation:
        return Operation.open("head", hand=Hand("burr", diameter=self.burr_diameter, removal_rate=150), plan=True)

    def start(self, random: np.random.Generator) -> Array:
        start: Array = self.entry + np.array([*random.uniform(-1, 1, 2), self.burr_diameter + 2.0])
        return start

    def goal(self) -> Array:
        return self.entry

    def judge(self, operation: Operation, touches: Optional[Touches]) -> tuple[float, bool, dict[str, float]]:
        tears = sum(e.name == "structure-torn" and e.fields["structure"] == "dura" for e in operation.events)
        if touches is None:
            self._tears = tears  # events of former episodes
        now = operation.read(self._low, self._high)[:, 0, 0].astype(float)
        share = float(np.mean((self._before - now) / (self._before + 1000.0)))
        is_torn = tears > self._tears
        return share - 2.0 * is_torn, share > 0.95 or is_torn, {"removed_share": share, "is_torn": float(is_torn)}


class SurgeryEnv:
    """An operation as a learning environment.

    An action is a velocity (x, y, z, mm/s) and the button (above 0.5: the tool runs). An observation is the
    position relative to the goal (mm), the force (N), contact (0 or 1) and the value of the task. A reset
    undoes what was cut; equal seeds and actions give equal bits.
    """

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(self, task: Union[Task, None] = None, ticks_per_step: int = 20, max_steps: int = 500,
                 max_speed: float = 20.0) -> None:
        if ticks_per_step < 1 or max_steps < 1 or not max_speed > 0:
            raise ValueError("ticks_per_step, max_steps and max_speed must be positive.")
        self.task: Task = task if task is not None else Pocket()
        self.ticks_per_step, self.max_steps, self.max_speed = ticks_per_step, max_steps, max_speed
        self.operation = self.task.open()
        self.action_space = _box([-max_speed] * 3 + [0], [max_speed] * 3 + [1])
        self.observation_space = _box([-np.inf] * 8, [np.inf] * 8)
        self._random = np.random.default_rng()
        self._position = np.zeros(3)
        self._steps = 0
        self._value = 0.0

    def reset(self, *, seed: Optional[int] = None,
              options: Optional[dict[str, Any]] = None) -> tuple[NDArray[np.float32], dict[str, Any]]:
        if seed is not None:
            self._random = np.random.default_rng(seed)
        self._position = self.task.start(self._random)
        # The end of the stroke, far from bone; then all strokes are undone.
        self.operation.run(self._position[None], buttons=0)
        while self.operation.removed_mm3 > 0:
            self.operation.undo()
        self.operation.reset()
        touches = self.operation.run(self._position[None], buttons=0)
        self._steps = 0
        self._value, _, facts = self.task.judge(self.operation, None)
        return self._observation(touches), dict(facts)

    def step(self, action: Any) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        velocity = np.asarray(action, float)
        if velocity.shape != (4,) or not np.isfinite(velocity).all():
            raise ValueError("An action is four finite numbers: a velocity in mm/s and the button.")
        step = np.clip(velocity[:3], -self.max_speed, self.max_speed) * 1e-3
        positions = self._position + step * np.arange(1, self.ticks_per_step + 1)[:, None]
        touches = self.operation.run(positions, buttons=int(velocity[3] > 0.5))
        self._position = positions[-1]
        self._steps += 1
        value, is_done, facts = self.task.judge(self.operation, touches)
        reward, self._value = value - self._value, value
        return self._observation(touches), reward, is_done, self._steps >= self.max_steps, dict(facts)

    def _observation(self, touches: Touches) -> NDArray[np.float32]:
        numbers = np.concatenate([self._position - self.task.goal(), touches.force[-1],
                                  [float(touches.contact[-1]), self._value]])
        observation: NDArray[np.float32] = numbers.astype(np.float32)
        return observation

    def close(self) -> None:
        """Ends the operation."""
        self.operation.end()
