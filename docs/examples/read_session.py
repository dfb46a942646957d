#!/usr/bin/env python3
"""Reads the tables of `trephine export`. Prints path length and strongest force of each hand, removed volume and events.

Usage: read_session.py FILE.h5
"""
import sys

import h5py
import numpy as np

with h5py.File(sys.argv[1]) as session:
    rate = session.attrs["rate"]
    for name, hand in session["hands"].items():
        path = np.linalg.norm(np.diff(hand["position"][:], axis=0), axis=1).sum()
        force = np.linalg.norm(hand["force"][:], axis=1)
        strongest = force.max() if len(force) else 0.0
        print(f"hand {name}: {len(force) / rate:.3f} s, path {path:.3f} mm, strongest force {strongest:.4f} N")
    removed = session["removed/volume"][:]
    print(f"removed: {removed[-1]:.4f} mm3")
    for tick, hand, sentence in zip(session["events/tick"], session["events/hand"], session["events/sentence"]):
        print(f"{tick / rate:.3f} s, hand {hand}: {sentence.decode()}")
