"""Learning environments: an operation with reset() and step(), with the results that Gymnasium defines.

Gymnasium need not be installed. If it is, SurgeryEnv is a gymnasium.Env, and its spaces are those of Gymnasium.

    env = SurgeryEnv(Pocket())
    observation, info = env.reset(seed=1)
    observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
"""

from __future__ import annotations

import copy
import importlib
import importlib.util
import os
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Optional, Protocol, Sequence, Union

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
        sample: NDArray[np.float32] = self._random.uniform(np.maximum(self.low, -1e6), np.minimum(self.high, 1e6)).astype(np.float32)
        return sample

    def contains(self, value: Any) -> bool:
        array = np.asarray(value)
        return array.shape == self.shape and bool((array >= self.low).all() and (array <= self.high).all())


_gymnasium: Any = importlib.import_module("gymnasium") if importlib.util.find_spec("gymnasium") else None
_Base: Any = _gymnasium.Env if _gymnasium else object


def _box(low: Any, high: Any) -> Any:
    low, high = np.asarray(low, np.float32), np.asarray(high, np.float32)
    return _gymnasium.spaces.Box(low, high, dtype=np.float32) if _gymnasium else Box(low, high)


class Task(Protocol):
    """Defines the operation, the start of the tool, and the reward. Each environment has a shallow copy of its task."""

    def open(self) -> Operation:
        """Opens the operation, with one hand and 1000 ticks per second."""

    def start(self, random: np.random.Generator) -> Array:
        """Returns the position at which an episode starts, mm."""

    def goal(self) -> Array:
        """Returns the point to which positions in observations are relative, mm."""

    def judge(self, operation: Operation, touches: Optional[Touches]) -> tuple[float, bool, dict[str, float]]:
        """Returns the value of the state, whether the task is done, and facts for `info`. The reward of a step
        is the growth of the value. `touches`: of the last step; None after a reset."""


def _air_of(scan: Scan) -> float:
    """Returns the intensity of removed matter."""
    return -1000.0 if scan.is_hounsfield else float(scan.array.min())


def _numbers(value: Any, count: int, name: str) -> Array:
    array: Array = np.asarray(value, float)
    if array.shape != (count,) or not np.isfinite(array).all():
        raise ValueError(f"{name} must be {count} finite numbers.")
    return array


class Pocket:
    """A pocket is drilled: the bone in a ball must be removed, and no bone outside the ball.

    Bone consists of the voxels of at least `iso`. A voxel at the border of the ball counts by the share of its
    volume in the ball. The value is the volume of bone removed in the ball, minus the volume of bone removed outside
    it, both divided by the volume of all bone in the ball. The task is done when 90 % of this bone is removed.
    """

    def __init__(self, scan: Optional[Scan] = None, centre: Any = (0.0, 0.0, 28.0), radius: float = 4.0,
                 iso: float = 300.0, burr_diameter: float = 3.0) -> None:
        self.scan = scan if scan is not None else Scan.phantom("sphere", spacing=(1, 1, 1), radius=30)
        self.centre, self.radius, self.iso = _numbers(centre, 3, "The centre"), float(radius), float(iso)
        self.burr_diameter = float(burr_diameter)
        self._air = _air_of(self.scan)
        if not 0 < self.radius < 1000 or not self.iso > self._air:
            raise ValueError("The radius must be between 0 and 1000 mm, and iso above the intensity of air.")
        axes = self.scan.world(np.eye(3)) - self.scan.world(np.zeros((3, 3)))
        self._voxel = abs(float(np.linalg.det(axes)))
        # The weight of a voxel is the share of its volume inside the ball.
        corners = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
        voxels = self.scan.voxel(self.centre + self.radius * corners)
        last = np.array(self.scan.shape[::-1]) - 1
        self._low = np.clip(np.floor(voxels.min(axis=0)), 0, last).astype(int)
        high = np.clip(np.ceil(voxels.max(axis=0)), 0, last).astype(int)
        z, y, x = np.mgrid[self._low[2] : high[2] + 1, self._low[1] : high[1] + 1, self._low[0] : high[0] + 1]
        points = np.stack([x, y, z], axis=-1).reshape(-1, 3).astype(float)
        weights = np.zeros(len(points))
        fine = (np.arange(4) + 0.5) / 4 - 0.5
        for dx, dy, dz in np.array(np.meshgrid(fine, fine, fine)).reshape(3, -1).T:
            distance = np.linalg.norm(self.scan.world(points + [dx, dy, dz]) - self.centre, axis=1)
            weights += (distance <= self.radius) / 64
        self._weights = weights.reshape(x.shape)
        self._high = high
        is_bone = self._part(self.scan.array) >= self.iso
        self.bone_mm3 = self._voxel * float(self._weights[is_bone].sum())
        if self.bone_mm3 <= 0:
            raise ValueError("The ball contains no bone. Move the centre, or lower iso.")

    def _part(self, voxels: Any) -> Any:
        (x0, y0, z0), (x1, y1, z1) = self._low, self._high
        return voxels[z0 : z1 + 1, y0 : y1 + 1, x0 : x1 + 1]

    def open(self) -> Operation:
        hand = Hand("burr", diameter=self.burr_diameter, removal_rate=200)
        operation = Operation.open(self.scan, hand=hand, iso=self.iso)
        self._inside = self._all = 0.0  # removed bone, mm3
        self._now = np.array(operation.array)
        return operation

    def start(self, random: np.random.Generator) -> Array:
        start: Array = self.centre + np.array([*random.uniform(-2, 2, 2), self.radius + 6.0])
        return start

    def goal(self) -> Array:
        return self.centre

    def judge(self, operation: Operation, touches: Optional[Touches]) -> tuple[float, bool, dict[str, float]]:
        changed = operation.take_changed()
        if changed is not None:
            low, high = changed
            (x0, y0, z0), (x1, y1, z1) = low, high
            box = np.s_[z0 : z1 + 1, y0 : y1 + 1, x0 : x1 + 1]
            before = self.scan.array[box].astype(float)
            is_bone = before >= self.iso
            now = operation.read(low, high)
            # A voxel approaches air in proportion to its removed share.
            growth = np.where(is_bone, (self._now[box].astype(float) - now) / np.maximum(before - self._air, 1.0), 0.0)
            self._all += self._voxel * float(growth.sum())
            self._now[box] = now
            first, now = self._part(self.scan.array).astype(float), self._part(self._now)
            removed = np.where(first >= self.iso, (first - now) / np.maximum(first - self._air, 1.0), 0.0)
            self._inside = self._voxel * float((self._weights * removed).sum())
        if touches is None:  # discards the rounding errors of the previous episode
            self._inside = self._all = 0.0
        share, outside = self._inside / self.bone_mm3, max(self._all - self._inside, 0.0)
        value = share - outside / self.bone_mm3
        return value, share >= 0.9, {"removed_share": share, "outside_mm3": outside}


class BurrHole:
    """A hole is drilled through the skull of the built-in head to the dura. No structure may be torn.

    The value is the removed share of the bone on a vertical line above the dura, minus 2 if a structure was torn.
    The task is done when more than 95 % of this bone is removed, or when a structure is torn.
    """

    def __init__(self, entry: Any = (15.0, -20.0), burr_diameter: float = 4.0) -> None:
        self.scan = Scan.phantom("head")
        self.burr_diameter = float(burr_diameter)
        position = self.scan.voxel(np.array([[*_numbers(entry, 2, "The entry"), 0.0]]))[0]
        x, y = (int(v) for v in np.rint(position[:2]))
        labels = self.scan.labels
        assert labels is not None
        bone = np.zeros(0, int)
        if 0 <= x < self.scan.shape[2] and 0 <= y < self.scan.shape[1]:
            names = self.scan.label_names
            is_bone = np.isin(labels[:, y, x], [names.index("cortical_bone"), names.index("diploe")])
            bone = np.flatnonzero(is_bone)
        if len(bone) == 0:
            raise ValueError("No bone on the vertical line through the entry. Choose another entry.")
        top = bottom = int(bone[-1])
        while is_bone[bottom - 1]:
            bottom -= 1
        if names[labels[bottom - 1, y, x]] not in ("dura", "venous_sinus"):
            raise ValueError("No dura below the bone at the entry. Choose another entry.")
        self._low, self._high = [x, y, bottom], [x, y, top]
        self._before = self.scan.array[bottom : top + 1, y, x].astype(float)
        self.entry: Array = self.scan.world(np.array([[x, y, top]], float))[0]
        self._first_event = 0

    def open(self) -> Operation:
        return Operation.open("head", hand=Hand("burr", diameter=self.burr_diameter, removal_rate=150), plan=True)

    def start(self, random: np.random.Generator) -> Array:
        start: Array = self.entry + np.array([*random.uniform(-1, 1, 2), self.burr_diameter + 2.0])
        return start

    def goal(self) -> Array:
        return self.entry

    def judge(self, operation: Operation, touches: Optional[Touches]) -> tuple[float, bool, dict[str, float]]:
        if touches is None:
            self._first_event = operation.event_count  # events up to the reset do not count
        is_torn = any(e.name == "structure-torn" for e in operation.events_since(self._first_event))
        now = operation.read(self._low, self._high)[:, 0, 0].astype(float)
        share = float(np.mean((self._before - now) / (self._before + 1000.0)))
        return share - 2.0 * is_torn, share > 0.95 or is_torn, {"removed_share": share, "is_torn": float(is_torn)}


class SurgeryEnv(_Base):  # type: ignore[misc]
    """An operation as a learning environment.

    An action is a velocity (x, y, z, mm/s) and the button (above 0.5: the tool runs). An observation is the
    position of the hand relative to the goal (mm), the force (N), contact (0 or 1) and the value of the task. A
    reset returns to the first state; equal seeds and actions give equal bits. As with a haptic device, the hand may
    move into bone: the tool stays on the surface of the bone, and the force increases.
    """

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(self, task: Union[Task, None] = None, ticks_per_step: int = 20, max_steps: int = 500,
                 max_speed: float = 20.0) -> None:
        if not (isinstance(ticks_per_step, int) and isinstance(max_steps, int)) or \
                min(ticks_per_step, max_steps) < 1 or not 0 < max_speed < 1e4:
            raise ValueError("ticks_per_step and max_steps must be positive integers, max_speed between 0 and 10000 mm/s.")
        self.task: Task = copy.copy(task) if task is not None else Pocket()
        self.ticks_per_step, self.max_steps, self.max_speed = ticks_per_step, max_steps, max_speed
        self.operation = self.task.open()
        self._first = self.operation.snapshot()
        self.action_space = _box([-max_speed] * 3 + [0], [max_speed] * 3 + [1])
        self.observation_space = _box([-np.inf] * 8, [np.inf] * 8)
        self._random = np.random.default_rng()
        self._position: Optional[Array] = None
        self._steps = 0
        self._value = 0.0

    def reset(self, *, seed: Optional[int] = None,
              options: Optional[dict[str, Any]] = None) -> tuple[NDArray[np.float32], dict[str, Any]]:
        if seed is not None:
            self._random = np.random.default_rng(seed)
        self._position = _numbers(self.task.start(self._random), 3, "The start")
        self.operation.restore(self._first)
        touches = self.operation.run(self._position[None], buttons=0)
        self._steps = 0
        self._value, _, facts = self.task.judge(self.operation, None)
        return self._observation(touches), dict(facts)

    def step(self, action: Any) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        if self._position is None:
            raise RuntimeError("The environment has no episode. Call reset() first.")
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
        assert self._position is not None
        numbers = np.concatenate([self._position - self.task.goal(), touches.force[-1],
                                  [float(touches.contact[-1]), self._value]])
        observation: NDArray[np.float32] = numbers.astype(np.float32)
        return observation

    def close(self) -> None:
        """Ends the operation."""
        self.operation.end()


class VectorEnv:
    """Several environments that step at the same time, on `threads` threads (default: one per environment, at most
    one per processor core). Equal seeds and actions give equal bits.

    Environments whose tasks have the same Scan share its voxels. After the end of an episode, the next step of that
    environment is a reset and ignores its action, as in Gymnasium's vector environments (autoreset mode "next step").
    """

    def __init__(self, environments: Sequence[SurgeryEnv], threads: Optional[int] = None) -> None:
        if not environments:
            raise ValueError("A vector needs at least one environment.")
        if len({id(one.operation) for one in environments}) != len(environments):
            raise ValueError("An environment occurs twice. Make a separate one for each position in the list.")
        self.environments = list(environments)
        self.num_envs = len(self.environments)
        self.single_action_space = self.environments[0].action_space
        self.single_observation_space = self.environments[0].observation_space
        self._pool = ThreadPoolExecutor(threads or min(self.num_envs, os.cpu_count() or 1))
        self._has_ended = [False] * self.num_envs

    def reset(self, *, seed: Optional[int] = None) -> tuple[NDArray[np.float32], list[dict[str, Any]]]:
        """Resets all environments; environment i has the seed `seed` + i."""
        seeds = [None if seed is None else seed + i for i in range(self.num_envs)]
        results = list(self._pool.map(lambda pair: pair[0].reset(seed=pair[1]), zip(self.environments, seeds)))
        self._has_ended = [False] * self.num_envs
        return np.stack([one[0] for one in results]), [one[1] for one in results]

    def step(self, actions: Any) -> tuple[NDArray[np.float32], Array, NDArray[np.bool_], NDArray[np.bool_],
                                          list[dict[str, Any]]]:
        """Steps all environments. Returns observations (N, 8), rewards, terminated and truncated (N,), and facts."""
        array = np.asarray(actions, float)
        if array.shape != (self.num_envs, 4):
            raise ValueError(f"Actions must have the shape ({self.num_envs}, 4).")

        def step_one(i: int) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
            if self._has_ended[i]:
                observation, facts = self.environments[i].reset()
                return observation, 0.0, False, False, facts
            return self.environments[i].step(array[i])

        results = list(self._pool.map(step_one, range(self.num_envs)))
        self._has_ended = [one[2] or one[3] for one in results]
        return (np.stack([one[0] for one in results]), np.array([one[1] for one in results], float),
                np.array([one[2] for one in results], bool), np.array([one[3] for one in results], bool),
                [one[4] for one in results])

    def close(self) -> None:
        """Ends all operations."""
        self._pool.shutdown()
        for one in self.environments:
            one.close()
