"""
Learn five things from ten presses each
=======================================

Presses of two days teach, those of a third day test: taxels drift from day to day, and that is where learners break.
"""

import tempfile
from pathlib import Path

import five_things
import matplotlib.pyplot as plt
import numpy as np

from varishold import TactileClassifier, read
from varishold.learning import labelled_presses

# %%
# Recordings as a lab has them: each press with its label and its day.
with tempfile.TemporaryDirectory() as folder:
    five_things.main(Path(folder))
    days = [read(Path(folder, f"{name}.npz")) for name in five_things.DAYS]
known = labelled_presses(days[:2], label="thing", group="day")
tested = labelled_presses(days[2:], label="thing")

# %%
# Features, learner and settings are chosen by cross-validation that keeps days together.
classifier = TactileClassifier().fit(known.presses, known.labels, groups=known.groups)
answers = classifier.explain(tested.presses)
right = np.array([answer.label == truth for answer, truth in zip(answers, tested.labels, strict=True)])
print(f"{right.mean():.0%} of {len(right)} presses of the third day are right")
for name, weight in answers[0].measures:
    print(f"{answers[0].label} by {name}: {weight:+.1f} nats")

# %%
# How sure it was, and whether it was right.
p = np.array([answer.probability for answer in answers])
figure, axes = plt.subplots(figsize=(6, 3))
axes.hist([p[right], p[~right]], bins=np.linspace(0, 1, 11), stacked=True, label=["right", "wrong"])
axes.set_xlabel("probability of the answer")
axes.set_ylabel("presses")
axes.legend()
plt.show()
