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
import operator
import os
import weakref
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Iterable, Optional, Protocol, Sequence, Union

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
    """Defines the operation, the start of the tool, and the reward. Each environment has a shallow copy of its task.

    A task may have a method `orientation`, which returns the rotation of the hand (w, x, y, z) during an episode.
    """

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


class _Removal:
    """Bone within a capsule is removed, and none outside: base of Pocket and Trough.

    Bone: voxels of at least `iso`; at the border of the capsule in proportion to their share inside. The value is the
    removed share of the bone in the capsule, minus the volume removed outside, relative to the same bone. Done at 90 %.
    """

    def __init__(self, scan: Optional[Scan], ends: Any, radius: float, iso: float, burr_diameter: float) -> None:
        self.scan = scan if scan is not None else Scan.phantom("sphere", spacing=(1, 1, 1), radius=30)
        self.ends = [_numbers(end, 3, "An end") for end in ends]
        self.radius, self.iso = float(radius), float(iso)
        self.burr_diameter = float(burr_diameter)
        self._air = _air_of(self.scan)
        if not 0 < self.radius < 1000 or not self.iso > self._air:
            raise ValueError("The radius must be between 0 and 1000 mm, and iso above the intensity of air.")
        axes = self.scan.world(np.eye(3)) - self.scan.world(np.zeros((3, 3)))
        self._voxel = abs(float(np.linalg.det(axes)))
        # Weights of the voxels around the capsule: the share of their volume inside.
        corners = self.radius * np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
        voxels = self.scan.voxel(np.concatenate([end + corners for end in self.ends]))
        last = np.array(self.scan.shape[::-1]) - 1
        self._low = np.clip(np.floor(voxels.min(axis=0)), 0, last).astype(int)
        high = np.clip(np.ceil(voxels.max(axis=0)), 0, last).astype(int)
        z, y, x = np.mgrid[self._low[2] : high[2] + 1, self._low[1] : high[1] + 1, self._low[0] : high[0] + 1]
        points = np.stack([x, y, z], axis=-1).reshape(-1, 3).astype(float)
        weights = np.zeros(len(points))
        fine = (np.arange(4) + 0.5) / 4 - 0.5
        for dx, dy, dz in np.array(np.meshgrid(fine, fine, fine)).reshape(3, -1).T:
            weights += (self._distance(self.scan.world(points + [dx, dy, dz])) <= self.radius) / 64
        self._weights = weights.reshape(x.shape)
        self._high = high
        is_bone = self._part(self.scan.array) >= self.iso
        self.bone_mm3 = self._voxel * float(self._weights[is_bone].sum())
        if self.bone_mm3 <= 0:
            raise ValueError("The region contains no bone. Move it, or lower iso.")

    def _distance(self, points: Array) -> Array:
        """Returns the distances of points to the axis of the capsule, mm."""
        begin, end = self.ends
        axis = end - begin
        square = float(axis @ axis)
        along = np.clip((points - begin) @ axis / square, 0, 1) if square > 0 else np.zeros(len(points))
        distances: Array = np.linalg.norm(points - begin - along[:, None] * axis, axis=1)
        return distances

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
        start: Array = self.ends[0] + np.array([*random.uniform(-2, 2, 2), self.radius + 6.0])
        return start

    def goal(self) -> Array:
        return self.ends[0]

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


class Pocket(_Removal):
    """A pocket is drilled: bone within a ball is removed, and none outside. The value is as that of Trough."""

    def __init__(self, scan: Optional[Scan] = None, centre: Any = (0.0, 0.0, 28.0), radius: float = 4.0,
                 iso: float = 300.0, burr_diameter: float = 3.0) -> None:
        super().__init__(scan, (centre, centre), radius, iso, burr_diameter)


class Trough(_Removal):
    """A trough is drilled, as next to a lamina: bone within `radius` of a line is removed, and none outside.

    The value is the removed share of the bone in this region, minus the volume removed outside, relative to the same
    bone. Done at 90 %.
    """

    def __init__(self, scan: Optional[Scan] = None, begin: Any = (-6.0, 0.0, 28.0), end: Any = (6.0, 0.0, 28.0),
                 radius: float = 2.5, iso: float = 300.0, burr_diameter: float = 3.0) -> None:
        super().__init__(scan, (begin, end), radius, iso, burr_diameter)


_phantoms: "weakref.WeakValueDictionary[str, Scan]" = weakref.WeakValueDictionary()


def _phantom(name: str) -> Scan:
    """Returns a built-in phantom. Tasks share it while one of them uses it."""
    scan = _phantoms.get(name)
    if scan is None:
        scan = _phantoms[name] = Scan.phantom(name)
    return scan


class ScrewTrack:
    """A track for a screw is probed through the left pedicle of L4 of the built-in spine, without leaving the bone.

    The hand holds the probe along a trajectory, and moves it. The value is the share of the length that the
    tip has reached, minus 2 if the probe left the bone. Done at the whole length, or when the probe leaves the bone.
    """

    def __init__(self, entry: Any = (16.3, 37.0, 6.5), target: Any = (8.2, -9.0, 6.5), length: float = 40.0) -> None:
        self.scan = _phantom("spine")
        self.entry = _numbers(entry, 3, "The entry")
        way = _numbers(target, 3, "The target") - self.entry
        size = float(np.linalg.norm(way))
        self.length = float(length)
        if not 0 < self.length <= 60 or not size > 0:
            raise ValueError("The length must be between 0 and 60 mm, and the target differ from the entry.")
        self.ahead: Array = way / size
        self._first_event = 0

    def orientation(self) -> Array:
        """Returns the rotation from the z axis to the shaft, which points out of the bone."""
        quaternion = np.array([1.0 - self.ahead[2], *np.cross((0.0, 0.0, 1.0), -self.ahead)])
        if np.linalg.norm(quaternion) < 1e-9:
            return np.array([0.0, 1.0, 0.0, 0.0])
        unit: Array = quaternion / np.linalg.norm(quaternion)
        return unit

    def open(self) -> Operation:
        return Operation.open(self.scan, hand=Hand("probe"), plan=True)

    def start(self, random: np.random.Generator) -> Array:
        start: Array = self.entry - 10.0 * self.ahead + [*random.uniform(-0.5, 0.5, 2), 0.0]
        return start

    def goal(self) -> Array:
        goal: Array = self.entry + self.length * self.ahead
        return goal

    def judge(self, operation: Operation, touches: Optional[Touches]) -> tuple[float, bool, dict[str, float]]:
        if touches is None:
            self._first_event = operation.event_count
        names = {event.name for event in operation.events_since(self._first_event)}
        depth = 0.0
        if touches is not None and "probe-entered" in names:
            depth = float((touches.proxy[-1] - self.entry) @ self.ahead)
        is_out = "probe-out" in names
        share = min(max(depth / self.length, 0.0), 1.0)
        return share - 2.0 * is_out, share >= 1.0 or is_out, {"depth_mm": depth, "is_out": float(is_out)}


class BurrHole:
    """A hole is drilled through the skull of the built-in head to the dura. No structure may be torn.

    The value is the removed share of the bone on a vertical line above the dura, minus 2 if a structure was torn.
    The task is done when more than 95 % of this bone is removed, or when a structure is torn.
    """

    def __init__(self, entry: Any = (15.0, -20.0), burr_diameter: float = 4.0) -> None:
        self.scan = _phantom("head")
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
        return Operation.open(self.scan, hand=Hand("burr", diameter=self.burr_diameter, removal_rate=150), plan=True)

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
        ticks_per_step, max_steps = operator.index(ticks_per_step), operator.index(max_steps)
        if not 0 < ticks_per_step <= 100_000 or max_steps < 1 or not 0 < max_speed < 1e4:
            raise ValueError("ticks_per_step must be 1 to 100000, max_steps at least 1, max_speed between 0 and 10000 mm/s.")
        if isinstance(task, type):
            raise TypeError(f"{task.__name__} is a class. Pass an object: SurgeryEnv({task.__name__}()).")
        self.task: Task = copy.copy(task) if task is not None else Pocket()
        self.ticks_per_step, self.max_steps, self.max_speed = ticks_per_step, max_steps, max_speed
        self.operation = self.task.open()
        if not isinstance(self.operation, Operation):
            raise TypeError("open() of a task must return an Operation.")
        if self.operation.hand_count != 1 or self.operation.rate != 1000:
            raise ValueError("open() of a task must return an operation with one hand and 1000 ticks per second.")
        self._first = self.operation.snapshot()
        self.action_space = _box([-max_speed] * 3 + [0], [max_speed] * 3 + [1])
        self.observation_space = _box([-np.inf] * 8, [np.inf] * 8)
        self._random = np.random.default_rng()
        self._position: Optional[Array] = None
        self._steps = 0
        self._value = 0.0
        self._is_closed = False

    def reset(self, *, seed: Optional[int] = None,
              options: Optional[dict[str, Any]] = None) -> tuple[NDArray[np.float32], dict[str, Any]]:
        if seed is not None:
            self._random = np.random.default_rng(seed)
        self._position = _numbers(self.task.start(self._random), 3, "The start")
        self.operation.restore(self._first)
        orientation = getattr(self.task, "orientation", None)
        self._turn: Optional[Array] = None if orientation is None else _numbers(orientation(), 4, "The orientation")
        touches = self._run(self._position[None], 0)
        self._steps = 0
        self._value, _, facts = self._judge(None)
        return self._observation(touches), facts

    def step(self, action: Any) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        if self._position is None:
            raise RuntimeError("The environment has no episode. Call reset() first.")
        velocity = _numbers(action, 4, "An action (a velocity in mm/s, and the button)")
        step = np.clip(velocity[:3], -self.max_speed, self.max_speed) * 1e-3
        positions = self._position + step * np.arange(1, self.ticks_per_step + 1)[:, None]
        touches = self._run(positions, int(velocity[3] > 0.5))
        self._position = positions[-1]
        self._steps += 1
        value, is_done, facts = self._judge(touches)
        reward, self._value = value - self._value, value
        return self._observation(touches), reward, is_done, self._steps >= self.max_steps, facts

    def _judge(self, touches: Optional[Touches]) -> tuple[float, bool, dict[str, float]]:
        result = self.task.judge(self.operation, touches)
        if not isinstance(result, tuple) or len(result) != 3 or not np.isfinite(result[0]):
            raise ValueError(f"judge() of a task must return a finite value, a truth value and a dict, not {result!r}.")
        return float(result[0]), bool(result[1]), dict(result[2])

    def _run(self, positions: Array, button: int) -> Touches:
        turns = None if self._turn is None else np.tile(self._turn, (len(positions), 1))
        return self.operation.run(positions, turns, button)

    def _observation(self, touches: Touches) -> NDArray[np.float32]:
        assert self._position is not None
        goal = _numbers(self.task.goal(), 3, "The goal")
        numbers = np.concatenate([self._position - goal, touches.force[-1],
                                  [float(touches.contact[-1]), self._value]])
        observation: NDArray[np.float32] = numbers.astype(np.float32)
        return observation

    def close(self) -> None:
        """Ends the operation. Further calls do nothing."""
        if not self._is_closed:
            self._is_closed = True
            self.operation.end()


class VectorEnv:
    """Several environments that step at the same time, on `threads` threads (default: one per environment, at most
    one per processor core). Equal seeds and actions give equal bits.

    Environments whose tasks have the same Scan share its voxels. After the end of an episode, the next step of that
    environment is a reset and ignores its action, as in Gymnasium's vector environments (autoreset mode "next step").
    """

    def __init__(self, environments: Iterable[SurgeryEnv], threads: Optional[int] = None) -> None:
        environments = list(environments)
        if not environments:
            raise ValueError("A vector needs at least one environment.")
        if len({id(one.operation) for one in environments}) != len(environments):
            raise ValueError("An environment occurs twice. Make a separate one for each position in the list.")
        self.environments = environments
        self.num_envs = len(self.environments)
        self.single_action_space = self.environments[0].action_space
        self.single_observation_space = self.environments[0].observation_space
        self._pool = ThreadPoolExecutor(threads or min(self.num_envs, os.cpu_count() or 1))
        self._has_ended = [False] * self.num_envs

    def reset(self, *, seed: Union[None, int, Sequence[Optional[int]]] = None
              ) -> tuple[NDArray[np.float32], list[dict[str, Any]]]:
        """Resets all environments. `seed`: a seed per environment, or a number; environment i then has `seed` + i."""
        if seed is None or isinstance(seed, (int, np.integer)):
            seeds = [None if seed is None else int(seed) + i for i in range(self.num_envs)]
        else:
            seeds = list(seed)
        if len(seeds) != self.num_envs:
            raise ValueError(f"Pass one seed, or {self.num_envs}.")

        def reset_one(env: SurgeryEnv, own: Optional[int]) -> tuple[NDArray[np.float32], dict[str, Any]]:
            first: tuple[NDArray[np.float32], dict[str, Any]] = env.reset(seed=own)
            return first

        results = list(self._pool.map(reset_one, self.environments, seeds))
        self._has_ended = [False] * self.num_envs
        return np.stack([one[0] for one in results]), [one[1] for one in results]

    def step(self, actions: Any) -> tuple[NDArray[np.float32], Array, NDArray[np.bool_], NDArray[np.bool_],
                                          list[dict[str, Any]]]:
        """Steps all environments. Returns observations (N, 8), rewards, terminated and truncated (N,), and facts."""
        array = np.asarray(actions, float)
        if array.shape != (self.num_envs, 4) or not np.isfinite(array).all():
            raise ValueError(f"Actions must be finite numbers of the shape ({self.num_envs}, 4). No environment was stepped.")

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
