"""Learning environments: resets that leave nothing behind, and equal bits for equal actions."""

import gc
import os
import resource

import numpy as np
import pytest
import trephine as tr
from trephine.env import BurrHole, Pocket, ScrewTrack, SurgeryEnv, Trough, VectorEnv


def drill(env, seed, steps, speed=4.0, radius=1.5):
    """Drills down at `speed` (mm/s) in circles of `radius` (mm) around the goal, for at most `steps` steps.

    Returns observations, rewards and the last result of step()."""
    observation, _ = env.reset(seed=seed)
    seen, rewards, result = [observation], [], None
    for i in range(steps):
        offset = radius * np.array([np.cos(0.4 * i), np.sin(0.4 * i)]) - observation[:2]
        result = env.step([*(10 * offset), -speed, 1])
        observation = result[0]
        seen.append(observation)
        rewards.append(result[1])
        if result[2] or result[3]:
            break
    return np.array(seen), np.array(rewards), result


def test_equal_actions_give_equal_bits_after_resets():
    env, other = SurgeryEnv(Pocket(), ticks_per_step=50), SurgeryEnv(Pocket(), ticks_per_step=50)
    first = drill(env, 5, 60)
    again = drill(env, 5, 60)
    another = drill(other, 5, 60)
    for run in (again, another):
        assert np.array_equal(first[0], run[0]) and np.array_equal(first[1], run[1])
    assert not np.array_equal(first[0], drill(env, 6, 60)[0])
    assert env.observation_space.contains(first[0][-1])
    env.reset(seed=1)
    assert env.operation.removed_mm3 == 0


def test_pocket_values_bone_inside_and_outside():
    env = SurgeryEnv(Pocket(), ticks_per_step=50, max_steps=70)
    _, rewards, (_, _, _, is_over, facts) = drill(env, 5, 70)
    assert is_over and facts["removed_share"] > 0.2
    task = env.task
    expected = facts["removed_share"] - facts["outside_mm3"] / task.bone_mm3
    assert rewards.sum() == pytest.approx(expected, abs=1e-9)
    # All removed bone is either inside the ball or outside.
    inside = facts["removed_share"] * task.bone_mm3
    assert inside + facts["outside_mm3"] == pytest.approx(env.operation.removed_mm3, rel=0.15)
    # Far from the ball, all removed bone is outside.
    env.reset(seed=5)
    env._position = np.array([34.0, 0.0, 0.0])
    for _ in range(20):
        _, _, _, _, facts = env.step([-8, 0, 0, 1])
    assert facts["removed_share"] == 0
    assert facts["outside_mm3"] == pytest.approx(env.operation.removed_mm3, rel=0.15)


def test_pocket_values_equal_cuts_equally_in_any_scan():
    def share_and_value(low, high, spacing):
        phantom = tr.Scan.phantom("sphere", spacing=spacing, radius=30)
        voxels = np.where(phantom.array > 300, high, low).astype(np.int16)
        scan = tr.Scan(voxels, spacing=phantom.spacing, origin=phantom.origin)
        env = SurgeryEnv(Pocket(scan, iso=0.5 * (low + high)), ticks_per_step=50, max_steps=70)
        _, rewards, (_, _, _, _, facts) = drill(env, 5, 70)
        return facts["removed_share"], rewards.sum()

    expected = share_and_value(-1000, 1600, (1, 1, 1))
    for low, high, spacing, within in ((0, 255, (1, 1, 1), 0.02), (-3000, 3000, (1, 1, 1), 0.02), (-1000, 1600, (1, 1, 3), 0.15)):
        assert share_and_value(low, high, spacing) == pytest.approx(expected, abs=within)


def test_more_strokes_than_an_operation_can_undo():
    env = SurgeryEnv(Pocket(), ticks_per_step=20, max_steps=700)
    first, _ = env.reset(seed=5)
    for k in range(640):
        env.step([0, 0, -20 if k < 20 else -0.5, k % 2])
    again, facts = env.reset(seed=5)
    assert np.array_equal(first, again) and facts["removed_share"] == 0 and env.operation.removed_mm3 == 0


def test_environments_have_their_own_task():
    task = Pocket()
    env, other = SurgeryEnv(task, ticks_per_step=50), SurgeryEnv(task, ticks_per_step=50)
    other.reset(seed=5)
    drill(env, 5, 40)
    _, reward, _, _, facts = other.step([0, 0, 0, 0])
    assert reward == 0 and facts["removed_share"] == 0


@pytest.mark.skipif("TREPHINE_WHOLE" not in os.environ, reason="longer than 5 s")
def test_burr_hole_ends_at_the_dura():
    env = SurgeryEnv(BurrHole(), ticks_per_step=50, max_steps=400)
    _, rewards, (_, _, is_done, _, facts) = drill(env, 1, 400, speed=2.0, radius=0.0)
    assert is_done and not facts["is_torn"] and rewards.sum() > 0.9
    # A plunge through the hole tears the dura. The next episode begins with an intact dura.
    for _ in range(40):
        _, _, _, _, facts = env.step([0, 0, -20, 1])
    assert facts["is_torn"]
    _, facts = env.reset(seed=1)
    assert not facts["is_torn"] and facts["removed_share"] == 0
    # The venous sinus is below the midline.
    env = SurgeryEnv(BurrHole(entry=(0, 0)), ticks_per_step=50, max_steps=400)
    drill(env, 1, 400, speed=4.0, radius=0.0)
    for _ in range(20):
        _, _, _, _, facts = env.step([0, 0, -20, 1])
    assert facts["is_torn"]


def test_invalid_input_is_refused():
    env = SurgeryEnv(Pocket())
    env.reset(seed=1)
    for action in ([0, 0, 0], [0, 0, np.nan, 1], np.zeros((2, 4))):
        with pytest.raises(ValueError, match="4 finite numbers"):
            env.step(action)
    with pytest.raises(ValueError, match="ticks_per_step must be"):
        SurgeryEnv(Pocket(), ticks_per_step=0)
    for centre in ((0, 0, 60), (500, 0, 0)):
        with pytest.raises(ValueError, match="no bone"):
            Pocket(centre=centre)
    with pytest.raises(ValueError, match="finite"):
        Pocket(centre=(np.nan, 0, 0))
    task = BurrHole()  # further tasks share its scan
    for entry in ((500, 0), (-120, 0), (np.nan, 0)):
        with pytest.raises(ValueError):
            BurrHole(entry=entry)
    assert BurrHole(entry=(0, 0)).scan is task.scan
    with pytest.raises(RuntimeError, match="reset"):
        SurgeryEnv(Pocket()).step([0, 0, 0, 0])


@pytest.mark.skipif("TREPHINE_WHOLE" not in os.environ, reason="longer than 5 s")
def test_resets_lose_no_memory():
    env = SurgeryEnv(Pocket(), ticks_per_step=50)

    def resident_mb():
        with open("/proc/self/statm", encoding="ascii") as file:
            return int(file.read().split()[1]) * 4096 / 1e6

    for _ in range(20):
        drill(env, 5, 30, speed=15.0)
    before = resident_mb()
    for _ in range(80):
        drill(env, 5, 30, speed=15.0)
    assert resident_mb() - before < 20


def test_a_vector_gives_the_bits_of_its_environments():
    scan = tr.Scan.phantom("sphere", spacing=(1, 1, 1), radius=30)
    vector = VectorEnv([SurgeryEnv(Pocket(scan), ticks_per_step=20, max_steps=12) for _ in range(3)], threads=2)
    single = [SurgeryEnv(Pocket(scan), ticks_per_step=20, max_steps=12) for _ in range(3)]
    observations, facts = vector.reset(seed=5)
    expected = [env.reset(seed=5 + i) for i, env in enumerate(single)]
    assert observations.shape == (3, 8) and len(facts) == 3
    assert np.array_equal(observations, np.stack([one[0] for one in expected]))
    random = np.random.default_rng(1)
    for step in range(13):
        actions = np.column_stack([random.uniform(-5, 5, (3, 2)), np.full(3, -20.0), np.ones(3)])
        observations, rewards, terminated, truncated, _ = vector.step(actions)
        if step < 12:
            results = [env.step(action) for env, action in zip(single, actions)]
            assert np.array_equal(observations, np.stack([one[0] for one in results]))
            assert np.array_equal(rewards, [one[1] for one in results])
            assert not terminated.any() and truncated.all() == (step == 11)
        else:  # all environments ended: this step resets them
            results = [env.reset() for env in single]
            assert np.array_equal(observations, np.stack([one[0] for one in results]))
            assert not rewards.any() and not truncated.any()
    with pytest.raises(ValueError, match="shape"):
        vector.step(np.zeros((2, 4)))
    with pytest.raises(ValueError, match="twice"):
        VectorEnv([single[0], single[0]])
    with pytest.raises(ValueError, match="at least one"):
        VectorEnv([])
    vector.close()
    with pytest.raises(tr.Error):
        vector.environments[0].reset()


def test_trough_counts_the_bone_around_its_line():
    task = Trough()
    # A cylinder with hemispherical ends of radius 2.5, in the middle of bone.
    inside = Trough(begin=(-6, 0, 10), end=(6, 0, 10))
    assert inside.bone_mm3 == pytest.approx(np.pi * 2.5**2 * 12 + 4 / 3 * np.pi * 2.5**3, rel=0.02)
    assert task.bone_mm3 < inside.bone_mm3  # a part is outside the ball of bone
    assert Trough(begin=(0, 0, 28), end=(0, 0, 28), radius=4).bone_mm3 == Pocket().bone_mm3
    env = SurgeryEnv(task, ticks_per_step=50, max_steps=200)
    env.reset(seed=2)
    facts, lowest, x, direction = {}, 26.5, -7.0, 1.0
    while lowest > 25:  # to and fro along the line, a little deeper each time
        for target in np.arange(-7.0, 7.1, 1.0)[:: int(direction)]:
            way = np.array([target, 0.0, lowest]) - env._position
            _, _, _, is_over, facts = env.step([*np.clip(20 * way, -20, 20), 1])
        direction, lowest = -direction, lowest - 0.75
    assert facts["removed_share"] > 0.3 and facts["removed_share"] * task.bone_mm3 > 2 * facts["outside_mm3"]


def follow(env, aside, steps=260):
    """Pushes the probe along its trajectory, shifted by `aside`. Returns the last result and the sum of rewards."""
    env.reset(seed=3)
    env._position = env.task.entry - 10 * env.task.ahead + aside
    total, result = 0.0, None
    for _ in range(steps):
        result = env.step([*(15 * env.task.ahead), 0])
        total += result[1]
        if result[2]:
            break
    return result, total


def test_screw_track_is_done_in_the_pedicle_and_fails_outside():
    env = SurgeryEnv(ScrewTrack(), ticks_per_step=20, max_steps=400)
    result, total = follow(env, np.zeros(3))
    assert result[2] and result[4]["is_out"] == 0 and total == pytest.approx(1, abs=1e-6)
    result, total = follow(env, np.array([-6.0, 0, 0]))  # toward the canal
    assert result[2] and result[4]["is_out"] == 1 and total < -1
    shaft = ScrewTrack(entry=(0, 0, 40), target=(0, 0, 0)).orientation()
    assert np.allclose(shaft, [1, 0, 0, 0])
    with pytest.raises(ValueError, match="length"):
        ScrewTrack(length=80)


def test_a_thousand_resets_keep_the_memory():
    def resident_mb():
        with open("/proc/self/statm", encoding="ascii") as file:
            return int(file.read().split()[1]) * resource.getpagesize() / 2**20

    env = SurgeryEnv(Pocket(tr.Scan.phantom("sphere", spacing=(2, 2, 2), radius=30)), ticks_per_step=50)
    memory = []
    for i in range(1000):
        env.reset(seed=i)
        env.step([0, 0, -20, 1])
        env.step([0, 0, -20, 1])
        if i in (99, 999):
            gc.collect()
            memory.append(resident_mb())
    assert memory[1] - memory[0] < 5, memory


def test_tasks_are_checked():
    class Own(Pocket):
        result = (0.0, False, {})
        rate = 1000.0

        def open(self):
            return tr.Operation.open(self.scan, iso=self.iso, rate=self.rate)

        def judge(self, operation, touches):
            return self.result

    task = Own()
    env = SurgeryEnv(task, ticks_per_step=np.int64(5))
    env.reset(seed=1)
    for result in ((np.nan, False, {}), (0.0, False), None):
        env.task.result = result
        with pytest.raises(ValueError, match="judge"):
            env.step([0, 0, 0, 0])
    env.close()
    env.close()
    task.rate = 500.0
    with pytest.raises(ValueError, match="1000 ticks per second"):
        SurgeryEnv(task)
    with pytest.raises(TypeError, match="is a class"):
        SurgeryEnv(Pocket)
    vector = VectorEnv(SurgeryEnv(Pocket(task.scan), ticks_per_step=5) for _ in range(2))
    vector.reset(seed=[1, None])
    with pytest.raises(ValueError, match="No environment was stepped"):
        vector.step([[0, 0, 0, 0], [np.nan, 0, 0, 0]])
    assert [env._steps for env in vector.environments] == [0, 0]
    with pytest.raises(ValueError, match="one seed, or 2"):
        vector.reset(seed=[1])
