"""Single random changes of the source, and whether the tests of the room they are made in notice them.

``python -m mutants --room grasp --number 40 --seed 0`` makes forty changes in ``src/varishold/grasp``, one at a time
and in a copy of the tree, runs the room's own tests on each, and says which were caught; so does
``make mutants ROOM=grasp N=40 SEED=0``. What was judged is kept in ``out/mutants``, so that a run that was stopped goes
on where it ended.
"""
