"""The yardstick: frames of faulty sensors and awkward poses, apart from all that the shipped tables learned from.

`rows` lists faults and poses, each at one strength. `media` presses the faces of `forms` by the solver of `solver`,
and `faults` says what sensors do to the frames. Frames of one seed are the same on every machine up to rounding.
"""
