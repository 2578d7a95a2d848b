"""
Follow touches while they last
==============================

A stream of readings becomes touches with a number each, events with a time, and an answer that gets surer. The skin is
simulated: with a sensor of yours only the address is another, as in ``serial:/dev/ttyACM0?preset=flexitac``.
"""

import matplotlib.pyplot as plt

from varishold.live import watch

# %%
# Every reading of a simulated skin that drifts, creeps and is noisy; presses come by themselves.
loads, answers = {}, {}
for seen in watch("sim:cone?seed=5&duration_s=15&rate_hz=50&speed=20", every=True):
    for name, pad in seen.pads.items():
        for event in pad.events:
            print(f"{event.time_s:6.2f} s  {name}, touch {event.track}: {event.kind}")
        for track in pad.tracks:
            loads.setdefault(track.number, []).append((seen.time_s, track.load))
            if track.answer is not None:
                answers[track.number] = track.answer

# %%
# What each was, by all frames of it.
for number, surface in answers.items():
    print(f"touch {number}: {surface.name}, p = {surface.probability:.2f}")

figure, axes = plt.subplots(figsize=(8, 3))
for number, course in loads.items():
    axes.plot(*zip(*course, strict=True), label=f"touch {number}")
axes.set_xlabel("time (s)")
axes.set_ylabel("load")
axes.legend()
plt.show()
