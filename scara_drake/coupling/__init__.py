"""Bilateral couplings: what a master and a slave exchange over a channel, one file each."""
