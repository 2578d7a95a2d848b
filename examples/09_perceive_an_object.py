"""
Know an object by touch after touch
===================================

A belief over objects: each touch is evidence, and the next one is the one that tells most. What is felt here comes from
a table of grasps; from a real hand it comes the same way.
"""

import matplotlib.pyplot as plt
import numpy as np

from varishold.perceive import Evidence, Library, Perceiver

rng = np.random.default_rng(0)
TYPICAL = {name: rng.integers(0, 2, 22).astype(bool) for name in ("cup", "ball", "brick", "pen")}
SIZE_M = {"cup": 0.08, "ball": 0.07, "brick": 0.09, "pen": 0.01}


def grasp(name: str) -> list[Evidence]:
    """Return one grasp: named numbers of any kind; one switch in twenty is read wrongly."""
    switches = TYPICAL[name] ^ (rng.random(22) < 0.05)
    values = {f"switch.{k}": float(on) for k, on in enumerate(switches)}
    return [Evidence("grasp", {**values, "width_m": rng.normal(SIZE_M[name], 0.01)})]


# %%
# Ten grasps of each object are what is known of it.
library = Library.from_examples({name: [grasp(name) for _ in range(10)] for name in TYPICAL})
perceiver = Perceiver(library)

# %%
# Touch until it is enough.
beliefs = []
for _ in range(4):
    update = perceiver.feel(grasp("brick")[0])
    answer = perceiver.answer()
    beliefs.append(answer.alternatives)
    print(f"{answer.object}, p = {answer.probability:.3f}: {update.verdict}. {update.why}")
    if perceiver.stopped:
        break

figure, axes = plt.subplots(figsize=(6, 3))
for name in TYPICAL:
    axes.plot(range(1, len(beliefs) + 1), [belief.get(name, 0.0) for belief in beliefs], "o-", label=name)
axes.set_xlabel("touches")
axes.set_ylabel("probability")
axes.legend()
plt.show()
