"""Bilateral couplings: what a master and a slave exchange over a delayed channel, one file each."""
