#!/usr/bin/env python3
"""Makes the models, the board and the motions of the four scenes in this folder: python3 make_scenes.py

Models of tools are in the frame of the hand: the origin is the held point, z points toward the hand."""
import gzip
import math
import os
import struct

FOLDER = os.path.dirname(os.path.abspath(__file__))


# ---- meshes: lists of vertices and of outward triangles ----

def add(a, b):
    return [x + y for x, y in zip(a, b)]


def sub(a, b):
    return [x - y for x, y in zip(a, b)]


def scaled(a, s):
    return [x * s for x in a]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def length(a):
    return math.sqrt(sum(x * x for x in a))


def unit(a):
    return scaled(a, 1 / length(a))


def join(*meshes):
    vertices, triangles = [], []
    for v, t in meshes:
        first = len(vertices)
        vertices += v
        triangles += [[first + i for i in corners] for corners in t]
    return vertices, triangles


def rows_to_mesh(rows, is_closed):
    """Joins circles of equally many vertices. Without `is_closed`, a triangle fan closes each end."""
    around = len(rows[0])
    vertices = [p for row in rows for p in row]
    triangles = []
    for r in range(len(rows) if is_closed else len(rows) - 1):
        low, high = r * around, (r + 1) % len(rows) * around
        for i in range(around):
            k = (i + 1) % around
            triangles += [[low + i, low + k, high + i], [low + k, high + k, high + i]]
    if not is_closed:
        for row, is_first in ((0, True), (len(rows) - 1, False)):
            centre = len(vertices)
            vertices.append(scaled([sum(p[a] for p in rows[row]) for a in range(3)], 1 / around))
            for i in range(around):
                a, b = row * around + i, row * around + (i + 1) % around
                triangles.append([centre, b, a] if is_first else [centre, a, b])
    return vertices, triangles


def sweep(points, radius, around=24):
    """A rod along a polygon. Corners should be rounded: bend() does that."""
    rows, side = [], None
    for n, p in enumerate(points):
        along = unit(sub(points[min(n + 1, len(points) - 1)], points[max(n - 1, 0)]))
        if side is None:
            side = unit(cross(along, [0, 0, 1] if abs(along[2]) < 0.9 else [1, 0, 0]))
        up = unit(cross(along, side))
        side = cross(up, along)
        rows.append([add(p, add(scaled(side, radius * math.cos(a)), scaled(up, radius * math.sin(a))))
                     for a in (2 * math.pi * i / around for i in range(around))])
    return rows_to_mesh(rows, False)


def bend(corners, radius, steps=8):
    """Replaces the inner corners of a polygon by arcs."""
    points = [corners[0]]
    for a, b, c in zip(corners, corners[1:], corners[2:]):
        back, forth = unit(sub(a, b)), unit(sub(c, b))
        half = 0.5 * math.acos(max(-1, min(1, sum(x * y for x, y in zip(back, forth)))))
        cut = radius / math.tan(half)
        middle = add(b, scaled(unit(add(back, forth)), radius / math.sin(half)))
        start, end = sub(add(b, scaled(back, cut)), middle), sub(add(b, scaled(forth, cut)), middle)
        turn = math.pi - 2 * half
        for i in range(steps + 1):
            s, e = math.sin(turn * (1 - i / steps)), math.sin(turn * i / steps)
            points.append(add(middle, scaled(add(scaled(start, s), scaled(end, e)), 1 / math.sin(turn))))
    return points + [corners[-1]]


def lathe(section, around=40):
    """A ring about the x axis. `section`: closed polygon of (x, radius), counter-clockwise."""
    rows = []
    for i in range(around):
        a = 2 * math.pi * i / around
        rows.append([[x, r * math.cos(a), r * math.sin(a)] for x, r in section])
    return rows_to_mesh(rows, True)


def net(distance, low, high, step):
    """Surface net of distance(p) < 0 (mm), with vertices moved onto the surface."""
    size = [int(math.ceil((h - l) / step)) + 1 for l, h in zip(low, high)]
    at = lambda i: [l + step * k for l, k in zip(low, i)]
    value = {}
    for x in range(size[0]):
        for y in range(size[1]):
            for z in range(size[2]):
                value[x, y, z] = distance(at((x, y, z)))

    def onto_surface(p):
        for _ in range(4):
            h = 1e-3
            slope = [(distance(add(p, e)) - distance(sub(p, e))) / (2 * h)
                     for e in ([h, 0, 0], [0, h, 0], [0, 0, h])]
            p = sub(p, scaled(slope, distance(p) / max(1e-6, sum(s * s for s in slope))))
        return p

    vertices, index = [], {}

    def vertex_of(cell):
        if cell not in index:
            crossings = []
            corner = lambda n: tuple(c + (n >> a & 1) for a, c in enumerate(cell))
            for n in range(8):
                for a in range(3):
                    if not n >> a & 1:
                        p, q = corner(n), corner(n | 1 << a)
                        if (value[p] < 0) != (value[q] < 0):
                            s = value[p] / (value[p] - value[q])
                            crossings.append(add(at(p), scaled(sub(at(q), at(p)), s)))
            middle = scaled([sum(c[a] for c in crossings) for a in range(3)], 1 / len(crossings))
            index[cell] = len(vertices)
            vertices.append(onto_surface(middle))
        return index[cell]

    triangles = []
    for p in value:
        for a in range(3):
            q = tuple(k + (i == a) for i, k in enumerate(p))
            if q not in value or (value[p] < 0) == (value[q] < 0):
                continue
            b, c = (a + 1) % 3, (a + 2) % 3
            cells = [tuple(k - (i == b) * db - (i == c) * dc for i, k in enumerate(p))
                     for db, dc in ((1, 1), (0, 1), (0, 0), (1, 0))]
            quad = [vertex_of(cell) for cell in cells]
            if value[p] >= 0:
                quad.reverse()
            triangles += [[quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]]
    return vertices, triangles


def write_obj(name, mesh, note):
    vertices, triangles = mesh
    with open(os.path.join(FOLDER, name), "w") as out:
        out.write(f"# {note} Made by make_scenes.py, mm.\n")
        for v in vertices:
            out.write("v " + " ".join(f"{x:.4g}" for x in v) + "\n")
        for t in triangles:
            out.write("f " + " ".join(str(i + 1) for i in t) + "\n")


# ---- shapes of the rabbit and the hammer: distances, mm ----

def ellipsoid(middle, radii, p):
    q = [(x - m) / r for x, m, r in zip(p, middle, radii)]
    return (length(q) - 1) * min(radii)


def capsule(a, b, radius, p):
    ab = sub(b, a)
    s = sum(x * y for x, y in zip(sub(p, a), ab)) / sum(x * x for x in ab)
    return length(sub(p, add(a, scaled(ab, max(0, min(1, s)))))) - radius


def rounded_box(middle, half, radius, p):
    q = [abs(x - m) - h + radius for x, m, h in zip(p, middle, half)]
    return length([max(x, 0) for x in q]) + min(0, max(q)) - radius


def blend(distances, width):
    """Smooth union."""
    least = min(distances)
    return least - width * math.log(sum(math.exp((least - d) / width) for d in distances))


def rabbit(p):
    return blend([ellipsoid([0, 0, 22], [30, 20, 22], p), ellipsoid([-24, 0, 48], [16, 14, 14], p),
                  capsule([-20, 5, 60], [-8, 9, 88], 4.5, p), capsule([-20, -5, 60], [-8, -9, 88], 4.5, p),
                  ellipsoid([30, 0, 18], [8, 8, 8], p), ellipsoid([-22, 11, 6], [12, 6, 6], p),
                  ellipsoid([-22, -11, 6], [12, 6, 6], p)], 1.5)


def hammer(p):
    return blend([rounded_box([0, 0, 0], [16, 7, 7], 2, p), capsule([0, 0, 4], [0, 0, 90], 4, p)], 0.7)


# ---- motions ----

def rotation(axis, degrees):
    half = math.radians(degrees) / 2
    return [x * math.sin(half) for x in unit(axis)] + [math.cos(half)]


def write_path(name, poses):
    """`poses`: (t, position, rotation or None)."""
    with open(os.path.join(FOLDER, name), "w") as out:
        out.write("t,x,y,z,qx,qy,qz,qw,button\n")
        for t, position, turn in poses:
            row = [t] + list(position) + (turn or [0, 0, 0, 1])
            out.write(",".join(f"{x:.6g}" for x in row) + ",0\n")


def main():
    # A board of 200 x 140 x 12 mm under the objects; its top is near z = 0.
    size, spacing = (52, 37, 7), 4.0
    values = [1000 if all(0 < k < n - 1 for k, n in zip((x, y, z), size)) else 0
              for z in range(size[2]) for y in range(size[1]) for x in range(size[0])]
    header = ("NRRD0004\ntype: int16\ndimension: 3\nspace: left-posterior-superior\n"
              f"sizes: {size[0]} {size[1]} {size[2]}\n"
              f"space directions: ({spacing},0,0) (0,{spacing},0) (0,0,{spacing})\n"
              f"space origin: ({-spacing * (size[0] - 1) / 2},{-spacing * (size[1] - 1) / 2},"
              f"{-spacing * (size[2] - 1.5)})\nkinds: domain domain domain\nendian: little\nencoding: gzip\n\n")
    with open(os.path.join(FOLDER, "board.nrrd"), "wb") as out:
        out.write(header.encode() + gzip.compress(struct.pack(f"<{len(values)}h", *values), mtime=0))

    write_obj("rabbit.obj", net(rabbit, [-48, -28, -4], [44, 28, 98], 3.3), "A rabbit.")
    write_obj("hammer.obj", net(hammer, [-20, -11, -11], [20, 11, 98], 2.2),
              "A hammer; the middle of its head is the origin.")

    post = lambda x: sweep([[x, 0, -2], [x, 0, 41]], 3, 16)
    write_obj("pipe.obj", join(sweep([[-60, 0, 45], [60, 0, 45]], 5, 32), post(-50)),
              "A pipe of 10 mm on a post at one end.")
    ring = [(3 * math.cos(a), 14 + 3 * math.sin(a)) for a in (2 * math.pi * i / 16 for i in range(16))]
    write_obj("torus.obj", lathe(ring, 48), "A torus about the x axis.")
    write_obj("tube.obj", lathe([(-20, 6), (20, 6), (20, 9), (-20, 9)], 48),
              "A tube of 12 mm inside and 18 mm outside.")

    def pipe_way(y, z, turns):
        return sweep(bend([[-70, y, z], [-20, y, z]] + turns, 10), 5, 20)
    write_obj("piping.obj", join(
        pipe_way(-25, 20, [[-20, -25, 60], [70, -25, 60]]),
        pipe_way(0, 55, [[-20, 0, 20], [70, 0, 20]]),
        pipe_way(25, 20, [[-20, 25, 60], [70, 25, 60]]),
        sweep([[25, -60, 40], [25, 60, 40]], 5, 20)), "Four pipes.")
    write_obj("tube-tool.obj", sweep(bend([[0, 26, 0], [0, 0, 0], [0, 0, 80]], 10), 3.5, 20),
              "A bent rod; its corner is the origin.")

    # Rabbit and hammer: strike the back with the head of the hammer, then press an ear with the handle.
    level, handle = rotation([1, 0, 0], 0), rotation([0, 1, 0], -70)
    write_path("rabbit-hammer.csv", [
        (0, [10, 0, 90], level), (0.6, [10, 0, 47], level), (0.9, [10, 0, 65], level),
        (1.4, [4, 0, 46], level), (2.0, [20, 0, 46], level), (2.4, [20, 0, 80], level),
        (3.2, [60, 9, 84], handle), (4.0, [30, 9, 80], handle), (4.6, [22, 9, 78], handle),
        (5.4, [60, 9, 95], handle), (6.0, [60, 0, 120], level)])
    # Pipe and torus: along the pipe, which the ring touches below; then pried by 75 degrees to both sides.
    pry = rotation([0, 0, 1], 75)
    write_path("pipe-torus.csv", [
        (0, [100, 0, 45], None), (1.0, [58, 0, 43], None), (1.4, [55, 0, 37], None),
        (3.0, [-10, 0, 37], None), (3.8, [-10, 0, 45], None), (4.6, [-10, 0, 45], pry),
        (5.8, [-10, 0, 45], rotation([0, 0, 1], -75)), (6.4, [-10, 0, 45], None),
        (7.6, [100, 0, 45], None)])
    # Pipe and tube: a hand that is 2 mm too low and turns by 12 degrees.
    write_path("pipe-tube.csv", [
        (0, [110, 0, 45], None), (1.0, [78, 0, 45], None), (2.4, [20, 0, 45], None),
        (3.0, [10, 0, 43], None), (3.8, [0, 0, 43], rotation([0, 1, 0], 12)),
        (4.6, [-10, 0, 45], rotation([0, 0, 1], 12)), (5.2, [-10, 0, 45], None),
        (7.0, [110, 0, 45], None)])
    # Piping and tube tool: down between the upper pipes, the hook under one of them, pulled up, and out again.
    level, turned = rotation([0, 0, 1], 0), rotation([0, 0, 1], -25)
    write_path("piping.csv", [
        (0, [45, -10, 130], level), (1.2, [45, -10, 45], level), (2.2, [45, 6, 45], turned),
        (3.0, [45, 6, 60], turned), (4.2, [45, 6, 62], turned), (5.0, [45, 6, 45], turned),
        (6.0, [45, -10, 45], level), (7.2, [45, -10, 130], level)])


if __name__ == "__main__":
    main()
