"""How the shipped parameters are made: generated frames, and what is learned from them."""
