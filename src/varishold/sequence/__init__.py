"""The automatic loop: the hand acts, the perceiver decides."""
