"""A learning environment: random search over a policy of two numbers learns to drill a pocket."""

import numpy as np
from trephine.env import Pocket, SurgeryEnv

env = SurgeryEnv(Pocket(), ticks_per_step=50, max_steps=150)


def play(speed: float, radius: float) -> float:
    """Drills down at `speed` (mm/s) on a circle of `radius` (mm). Returns the sum of the rewards."""
    observation, _ = env.reset(seed=7)
    total = 0.0
    for i in range(env.max_steps):
        angle = 0.4 * i
        goal = radius * np.array([np.cos(angle), np.sin(angle)])
        is_deep = observation[2] < -1
        action = [*(10 * (goal - observation[:2])), 0 if is_deep else -speed, 1]
        observation, reward, terminated, truncated, _ = env.step(action)
        total += reward
        if terminated or truncated:
            break
    return total


random = np.random.default_rng(3)
best = np.array([6.0, 0.5])
score = first = play(*best)
for _ in range(20):
    candidate = np.clip(best + random.normal(0, 1, 2), 0, 20)
    result = play(*candidate)
    if result > score:
        best, score = candidate, result
print(f"sum of rewards: {first:.2f} at first, {score:.2f} after 20 episodes")
print(f"policy: {best[0]:.1f} mm/s down, circles of {best[1]:.1f} mm radius")
assert score > first
