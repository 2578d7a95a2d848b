"""Hostile inputs and sudden ends: what the program must survive, tried by the hundred thousand.

`python -m hostile.fuzz` reads mutated files with every reader; `python -m hostile.kills` kills every command that
writes at random moments.
"""
