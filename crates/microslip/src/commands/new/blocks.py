"""Plates and rings of quadrilateral blocks, meshed by Gmsh with hexahedra or with quadratic tetrahedra.

A body is drawn in plan (x, y) as blocks, four-sided pieces whose sides are straight or arcs of circles, and is extruded along z.
Blocks share their corners and sides. Lengths are in mm.
"""

import argparse
import math

import gmsh

# A body is meshed this far away from the other one (mm), since Gmsh would glue surfaces that coincide; then it is moved back.
APART = 1000.0

# Edges of the lower body relative to those of the upper one where the meshes shall not match.
LOWER = 1.25

# Fewest edges along a quarter of a hole.
QUARTER = 4


def options(description, path, bolts, size):
    """Command line of a mesh script that writes to `path`. `bolts` are the number, the fewest and the most, if it may be chosen."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--mesh", choices=["hex", "hex-nonmatching", "tet"], default="hex",
                        help="hexahedra (default); hexahedra whose faces do not match those of the other body; tetrahedra")
    parser.add_argument("--order", type=int, choices=[1, 2], default=2, help="order of the elements (default 2)")
    if bolts is not None:
        number, fewest, most = bolts
        parser.add_argument("--bolts", type=int, choices=range(fewest, most + 1), default=number, help=f"number of bolts (default {number})")
    parser.add_argument("--size", type=float, default=size, help=f"length of edges in mm (default {size:g})")
    parser.add_argument("--out", default=path, help=f"file to write (default {path})")
    return parser.parse_args()


def divisions(length, size):
    return max(1, round(length / size))


class Body:
    """A body in plan at z = `level`, the upper or the lower one of two."""

    def __init__(self, name, given, level, is_upper):
        self.name, self.is_hex = name, given.mesh.startswith("hex")
        self.size = LOWER * given.size if given.mesh == "hex-nonmatching" and not is_upper else given.size
        self.moved = 0.0 if is_upper else APART
        self.level = level - self.moved
        self.points, self.curves, self.counts = {}, {}, {}
        self.holes, self.layers, self.volumes = [], [], []

    def point(self, x, y):
        key = (round(x, 6), round(y, 6))
        if key not in self.points:
            self.points[key] = gmsh.model.geo.addPoint(x, y, self.level)
        return self.points[key]

    def curve(self, a, b, centre, count):
        """Side from `a` to `b`: straight, or an arc about `centre`. Its sign is its sense."""
        a, b = self.point(*a), self.point(*b)
        key = (min(a, b), max(a, b))
        if key not in self.curves:
            add = gmsh.model.geo.addLine if centre is None else lambda p, q: gmsh.model.geo.addCircleArc(p, self.point(*centre), q)
            self.curves[key] = add(*key)
            if self.is_hex:
                gmsh.model.geo.mesh.setTransfiniteCurve(self.curves[key], count + 1)
        return self.curves[key] if key == (a, b) else -self.curves[key]

    def block(self, corners, counts, centres=(None,) * 4):
        """Block of four corners in the positive sense. `counts` are edges along its first and second side, `centres` those of sides that
        are arcs. Returns its surface."""
        sides = [self.curve(corners[i], corners[(i + 1) % 4], centres[i], counts[i % 2]) for i in range(4)]
        surface = gmsh.model.geo.addPlaneSurface([gmsh.model.geo.addCurveLoop(sides)])
        if self.is_hex:
            gmsh.model.geo.mesh.setTransfiniteSurface(surface, cornerTags=[self.point(*corner) for corner in corners])
            gmsh.model.geo.mesh.setRecombine(2, surface)
        return surface

    def bolt_hole(self, centre, hole, seat, corners, around, centres=(None,) * 4):
        """A four-sided piece with a hole: a ring of blocks from the hole to the edge of the seat (diameters), and a ring from there to the
        sides. `around` are edges along the first and second side. Returns the surfaces of the two rings."""
        x, y = centre
        angles = [math.atan2(cy - y, cx - x) for cx, cy in corners]
        on = lambda diameter: [(x + diameter / 2 * math.cos(a), y + diameter / 2 * math.sin(a)) for a in angles]
        inner, middle = on(hole), on(seat)
        reach = min(math.dist(centre, corner) for corner in corners) - seat / 2
        across = [divisions((seat - hole) / 2, 0.7 * self.size), divisions(0.8 * reach, self.size)]
        rings = [], []
        for i in range(4):
            j = (i + 1) % 4
            n = around[i % 2]
            rings[0].append(self.block([inner[i], middle[i], middle[j], inner[j]], [across[0], n], [None, centre, None, centre]))
            rings[1].append(self.block([middle[i], corners[i], corners[j], middle[j]], [across[1], n], [None, centres[i], None, centre]))
        self.holes.append((centre, hole / 2, min(self.size, 0.5 * math.pi * hole / 2 / QUARTER)))
        return rings

    def extrude(self, surfaces, height):
        """Extrudes surfaces along z, in two layers of elements at least; returns those on the other side, in the same order."""
        count = max(2, divisions(abs(height), self.size))
        self.layers.append((height, abs(height) / count))
        more = {"numElements": [count], "recombine": True} if self.is_hex else {}
        made = gmsh.model.geo.extrude([(2, s) for s in surfaces], 0, 0, height, **more)
        at = [i for i, (dimension, _) in enumerate(made) if dimension == 3]
        self.volumes += [made[i][1] for i in at]
        return [made[i - 1][1] for i in at]

    def edge(self, x, y, z):
        """Length of edges of tetrahedra at a position: shorter at a hole, and no longer than the layers of hexahedra would be thick."""
        near = [arc + 0.5 * max(0.0, math.dist(centre, (x, y)) - radius) for centre, radius, arc in self.holes]
        within = [thickness for height, thickness in self.layers if -1e-6 < (z - self.level) / height < 1.0 + 1e-6]
        return min([self.size, *near, *within])


def make(given, upper, lower):
    """Draws, meshes and writes two bodies that touch at one face. `upper` and `lower` draw one each, and return it with its surfaces in contact and, bolt
    by bolt, those below heads or nuts."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Verbosity", 1)
    (above, of_upper, heads), (below, of_lower, nuts) = upper(), lower()
    groups = {"upper contact": of_upper, "lower contact": of_lower}
    for i, (head, nut) in enumerate(zip(heads, nuts), 1):
        groups[f"head {i}"], groups[f"nut {i}"] = head, nut
    write(given, [above, below], groups)
    gmsh.finalize()


def write(given, bodies, groups):
    """Meshes the upper and the lower body and writes the file. `groups` are lists of surfaces by name."""
    upper, lower = bodies
    gmsh.model.geo.synchronize()
    for body in bodies:
        gmsh.model.addPhysicalGroup(3, body.volumes, name=body.name)
    for name, surfaces in groups.items():
        gmsh.model.addPhysicalGroup(2, surfaces, name=name)
    gmsh.model.mesh.setSizeCallback(lambda dimension, tag, x, y, z, length: (upper if z > -APART / 2 else lower).edge(x, y, z))
    gmsh.option.setNumber("Mesh.ElementOrder", given.order)
    # Hexahedra of 20 nodes, not of 27.
    gmsh.option.setNumber("Mesh.SecondOrderIncomplete", 1)
    gmsh.model.mesh.generate(3)
    for body in bodies:
        entities = [(3, volume) for volume in body.volumes]
        for dimension in (3, 2, 1):
            entities += gmsh.model.getBoundary([e for e in entities if e[0] == dimension], combined=False, oriented=False)
        gmsh.model.mesh.affineTransform([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, body.moved], list(dict.fromkeys(entities)))
    nodes = len(gmsh.model.mesh.getNodes()[0])
    elements = sum(len(tags) for tags in gmsh.model.mesh.getElements(3)[1])
    gmsh.write(given.out)
    print(f"{given.out}: {nodes} nodes, {elements} elements")
