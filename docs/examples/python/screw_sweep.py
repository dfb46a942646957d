"""Shifts a pedicle screw in L4 of the built-in spine from lateral to medial, and prints the breach of each shift.

Also writes a chart if you name its file: /usr/bin/python3 screw_sweep.py chart.svg
"""

import sys

import numpy as np
import trephine as tr

operation = tr.Operation.open("spine", plan=True)
entry, target = (np.array(point) for point in operation.trajectories["L4 left pedicle"])  # mm
start = operation.snapshot()

shifts = np.arange(-6.0, 6.1, 1.0)  # mm, toward the canal
breaches = []
for shift in shifts:
    operation.restore(start)
    offset = np.array((-shift, 0, 0))
    operation.command("place-screw", entry=tuple(entry + offset), target=tuple(target + offset), diameter=6, length=45,
                      seconds=0, forced=True)
    operation.command("judge-screw", vertebra="L4")
    judged = [event for event in operation.events if event.name == "screw-judged"][-1].fields
    breaches.append(judged["breach"])
    print(f"{shift:5.1f} mm toward the canal: breach {judged['breach']:5.1f} mm {judged['wall']:9} grade {judged['grade']}")

if len(sys.argv) > 1:
    x = 60 + 560 * (shifts - shifts[0]) / (shifts[-1] - shifts[0])
    y = 260 - 220 * (np.array(breaches) + 4) / 12
    limits = [(f"{grade} above {limit}", 260 - 220 * (limit + 4) / 12) for grade, limit in zip("BCDE", (0, 2, 4, 6))]
    lines = [f'<path d="M60 {at:.1f}H620" stroke="#ccc"/><text x="628" y="{at + 5:.1f}" fill="#555">{text}</text>'
             for text, at in limits]
    dots = [f'<circle cx="{a:.1f}" cy="{b:.1f}" r="4" fill="#b5651d"/>' for a, b in zip(x, y)]
    ticks = [f'<text x="{a:.1f}" y="286" text-anchor="middle" fill="#444">{shift:g}</text>' for a, shift in zip(x, shifts)]
    curve = f'<path d="M{" L".join(f"{a:.1f} {b:.1f}" for a, b in zip(x, y))}" fill="none" stroke="#b5651d" stroke-width="2"/>'
    with open(sys.argv[1], "w", encoding="utf-8") as file:
        file.write('<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 720 320" font-family="sans-serif" font-size="15">'
                   '<rect width="720" height="320" fill="#fbfaf7"/>'
                   '<text x="60" y="24" fill="#222">Breach of the pedicle, mm; grades by Gertzbein and Robbins</text>'
                   + "".join([*lines, curve, *dots, *ticks])
                   + '<text x="340" y="310" text-anchor="middle" fill="#444">shift toward the canal, mm</text></svg>\n')
