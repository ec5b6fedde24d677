// The bodies of a mesh in space, and what is picked of them.

const PICKED = "#f0e442";
const HELD = "#4b2e83";
const USED = "#d55e00";
const UNUSED = "#9a9a9a";
const BOLT = "#222222";
const RESPONSE = "#cc79a7";
const FORCE = "#009e73";

/** Part of the size of the model by which bodies that touch are drawn apart at most. */
const APART = 0.35;

const minus = (a, b) => a.map((v, c) => v - b[c]);
const cross = (a, b) => [0, 1, 2].map((c) => a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3]);
const lengthOf = (a) => Math.hypot(...a);

/** Colour of a body, apart from those of marks for readers of any eyes, in light shades. */
function bodyColour(body) {
  const shades = COLOURS.filter((_, i) => ![1, 3, 6, 7].includes(i));
  const colour = new THREE.Color(shades[body % shades.length]).lerp(new THREE.Color("#ffffff"), 0.45);
  return colour;
}

/** The outer surface as arrays, with its smooth surfaces: body, area, centre, normal, faces that touch. */
function readShape({ named, ...shape }) {
  const numbers = (name) => arrayOf(Uint32Array, shape[name]);
  const [triangles, owners, bodies, patches, touching] = ["triangles", "face_of_triangle", "bodies", "patches", "touching"].map(numbers);
  const positions = arrayOf(Float32Array, shape.positions);
  const raw = (node) => Array.from(positions.subarray(3 * node, 3 * node + 3));
  const surfaces = [];
  let found = null;
  /** Middles of the faces, once something asks for them. */
  function middles() {
    if (found === null) {
      const corners = [];
      owners.forEach((face, i) => {
        corners[face] = new Set([...(corners[face] ?? []), ...triangles.subarray(3 * i, 3 * i + 3)]);
      });
      found = corners.map((nodes) => [...nodes].map(raw).reduce((sum, x) => sum.map((v, c) => v + x[c] / nodes.size), [0, 0, 0]));
    }
    return found;
  }
  owners.forEach((face, i) => {
    const [a, b, c] = [0, 1, 2].map((k) => raw(triangles[3 * i + k]));
    const normal = cross(minus(b, a), minus(c, a)).map((v) => v / 2);
    const area = lengthOf(normal);
    const surface = (surfaces[patches[face]] ??= { number: patches[face], body: bodies[face], area: 0, centre: [0, 0, 0], normal: [0, 0, 0], nodes: new Set(), pairs: new Set(), faces: new Set() });
    surface.area += area;
    surface.faces.add(face);
    [a, b, c].forEach((x, k) => {
      surface.nodes.add(triangles[3 * i + k]);
      x.forEach((v, j) => {
        surface.centre[j] += (area * v) / 3;
      });
    });
    normal.forEach((v, j) => {
      surface.normal[j] += v;
    });
    if (touching[face] > 0) {
      surface.pairs.add(touching[face] - 1);
    }
  });
  surfaces.forEach((surface) => {
    // Without the round-off of a sum about zero.
    const extent = Math.sqrt(surface.area);
    surface.centre = surface.centre.map((v) => v / surface.area).map((v) => (Math.abs(v) < 1e-9 * extent ? 0 : v));
    const size = lengthOf(surface.normal);
    surface.flat = size > 0.99 * surface.area;
    surface.normal = surface.normal.map((v) => Number((v / (size || 1)).toFixed(9)) + 0);
  });
  const nodeBody = new Uint32Array(positions.length / 3);
  triangles.forEach((node, i) => {
    nodeBody[node] = bodies[owners[Math.floor(i / 3)]];
  });
  return {
    positions, triangles, owners, bodies, patches, touching, surfaces, nodeBody,
    /** Position of a node in the digits that single precision has. */
    at: (node) => raw(node).map((v) => Number(v.toPrecision(7))),
    /** Of some faces the one whose middle is nearest to a point. */
    faceNear(faces, point) {
      const away = (face) => lengthOf(minus(middles()[face], point));
      let [best, least] = [-1, Infinity];
      for (const face of faces) {
        const distance = away(face);
        if (distance < least) {
          [best, least] = [face, distance];
        }
      }
      return best;
    },
    /** Middle of a face in the digits that single precision has. */
    middle: (face) => middles()[face].map((v) => Number(v.toPrecision(7))),
    edges: numbers("edges"),
    labels: shape.labels,
    named: named.map(([name, faces]) => ({ name, faces: new Set(arrayOf(Uint32Array, faces)) })),
    /** Of some nodes the nearest to a point. */
    nearest(nodes, [x, y, z]) {
      let [best, least] = [-1, Infinity];
      for (const node of nodes) {
        const distance = (positions[3 * node] - x) ** 2 + (positions[3 * node + 1] - y) ** 2 + (positions[3 * node + 2] - z) ** 2;
        if (distance < least) {
          [best, least] = [node, distance];
        }
      }
      return best;
    },
  };
}

/** Triangles of a rod between two points. */
function rod(a, b, radius, ends = [1, 1]) {
  const [from, to] = [new THREE.Vector3(...a), new THREE.Vector3(...b)];
  const along = to.clone().sub(from).normalize();
  const side = orthogonalTo(along);
  const other = new THREE.Vector3().crossVectors(along, side);
  const rim = (centre, size, k) => centre.clone().addScaledVector(side, size * radius * Math.cos((k * TURN) / 16)).addScaledVector(other, size * radius * Math.sin((k * TURN) / 16));
  const corners = [];
  for (let k = 0; k < 16; k += 1) {
    const [p, q, r, s] = [rim(from, ends[0], k), rim(from, ends[0], k + 1), rim(to, ends[1], k), rim(to, ends[1], k + 1)];
    corners.push(p, q, r, r, q, s, from, q, p, to, r, s);
  }
  return corners.flatMap((v) => [v.x, v.y, v.z]);
}

function orthogonalTo(along) {
  const axis = Math.abs(along.x) < 0.7 ? new THREE.Vector3(1, 0, 0) : new THREE.Vector3(0, 1, 0);
  return axis.addScaledVector(along, -axis.dot(along)).normalize();
}

/**
 * Shows the bodies in `host`. `marks()` says what is marked: {interfaces, supports: sets of faces, bolts: [{axis, radius, used}], arrows: [{at, direction, colour, into}]}.
 * `picked` is told the number of a bolt, or a smooth surface and a point on it.
 */
function showModel(host, shape, facts, marks, picked) {
  if (!hasWebGL()) {
    host.append(element("p", { class: "told" }, "This browser has no WebGL, without which nothing can be drawn in space. The lists have the same faces, bolts and points."));
    return { refresh: () => {}, select: () => {} };
  }
  const box = boxOf(shape.positions);
  const size = lengthOf(minus(box[1], box[0]));
  const controls = element("div", { class: "controls", role: "group", "aria-label": "View" });
  const view = makeView(host, "The bodies in space; a click picks a face or a bolt", { box, ...upright(box) });
  host.append(controls);
  const count = shape.triangles.length;
  const mesh = colouredMesh(new Float32Array(3 * count), new Float32Array(3 * count), new THREE.MeshLambertMaterial({ vertexColors: true, flatShading: true, side: THREE.DoubleSide }));
  const moved = new Float32Array(shape.positions);
  const edges = edgeLines(moved, shape.edges, 0x333333, 0.6);
  mesh.frustumCulled = false;
  edges.frustumCulled = false;
  view.scene.add(mesh, edges);
  const hidden = new Set();
  let rods = [];
  let selected = null;
  let apart = facts.bodies.length > 1 ? 0.4 : 0;

  /** Way by which each body is drawn apart from those that it touches: the first of a pair against the normal. */
  function ways() {
    const found = new Map();
    const push = (v, normal, sign) => v.map((x, c) => x + sign * normal[c] * apart * APART * size);
    for (let body = 0; body < facts.bodies.length; body += 1) {
      const next = found.has(body) ? [] : [body];
      found.set(body, found.get(body) ?? [0, 0, 0]);
      while (next.length > 0) {
        const own = next.pop();
        for (const { bodies: [a, b], normal } of facts.touching) {
          const other = own === a ? b : a;
          if ((own === a || own === b) && !found.has(other)) {
            found.set(other, push(found.get(own), normal, own === a ? 1 : -1));
            next.push(other);
          }
        }
      }
    }
    return found;
  }

  function refresh() {
    const { interfaces, supports, bolts, arrows } = marks();
    const way = ways();
    shape.nodeBody.forEach((body, node) => {
      for (let c = 0; c < 3; c += 1) {
        // All in one point, what is hidden has no size.
        moved[3 * node + c] = hidden.has(body) ? box[0][c] : shape.positions[3 * node + c] + way.get(body)[c];
      }
    });
    const { position, color } = mesh.geometry.attributes;
    const special = [PICKED, HELD, USED, UNUSED].map((name) => new THREE.Color(name));
    const own = facts.bodies.map((_, body) => bodyColour(body));
    shape.triangles.forEach((node, corner) => {
      const face = shape.owners[Math.floor(corner / 3)];
      const pair = shape.touching[face];
      const colour = selected === shape.patches[face] ? special[0] : supports.has(face) ? special[1] : pair > 0 ? special[interfaces.has(pair - 1) ? 2 : 3] : own[shape.bodies[face]];
      position.array.set(moved.subarray(3 * node, 3 * node + 3), 3 * corner);
      color.array.set([colour.r, colour.g, colour.b], 3 * corner);
    });
    position.needsUpdate = true;
    color.needsUpdate = true;
    mesh.geometry.computeBoundingSphere();
    mesh.geometry.boundingSphere.radius = 10 * size;
    edges.geometry.attributes.position.needsUpdate = true;
    rods.forEach((old) => {
      view.scene.remove(old);
      old.geometry.dispose();
    });
    rods = [
      ...bolts.map(({ axis, radius, used }, number) => solid(rod(...along(axis, [...way.values()]), radius), used ? BOLT : UNUSED, used ? 1 : 0.45, number)),
      ...arrows.flatMap(({ at, direction, colour, into, body }) => {
        const start = at.map((v, c) => v + (way.get(body) ?? [0, 0, 0])[c]);
        const tip = (part) => start.map((v, c) => v + part * 0.14 * size * direction[c]);
        const [head, neck, tail] = into ? [start, tip(0.35), tip(1)] : [tip(1), tip(0.65), start];
        return [solid(rod(tail, neck, 0.006 * size), colour, 1), solid(rod(neck, head, 0.018 * size, [1, 0]), colour, 1)];
      }),
    ];
    rods.forEach((made) => view.scene.add(made));
    view.refresh();
  }

  /** An axis as long as bodies are apart on it. */
  function along([a, b], ways) {
    const unit = minus(a, b).map((v) => v / (lengthOf(minus(a, b)) || 1));
    const parts = ways.map((way) => way.reduce((sum, v, c) => sum + v * unit[c], 0));
    const beyond = [Math.max(...parts), Math.min(...parts)].map((part) => part + 0.02 * size * Math.sign(part));
    return [a, b].map((end, i) => end.map((v, c) => v + beyond[i] * unit[c]));
  }

  function solid(corners, colour, opacity, number) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(corners), 3));
    geometry.computeVertexNormals();
    const made = new THREE.Mesh(geometry, new THREE.MeshLambertMaterial({ color: colour, transparent: opacity < 1, opacity, side: THREE.DoubleSide }));
    made.userData.bolt = number;
    return made;
  }

  const ray = new THREE.Raycaster();
  let pressed = [0, 0];
  view.canvas.addEventListener("pointerdown", (event) => {
    pressed = [event.clientX, event.clientY];
  });
  view.canvas.addEventListener("click", (event) => {
    if (Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > 4) {
      return;
    }
    const frame = view.canvas.getBoundingClientRect();
    ray.setFromCamera(new THREE.Vector2((2 * (event.clientX - frame.left)) / frame.width - 1, 1 - (2 * (event.clientY - frame.top)) / frame.height), view.camera);
    const hit = ray.intersectObjects([mesh, ...rods.filter((made) => made.userData.bolt !== undefined)])[0];
    if (hit?.object === mesh) {
      const face = shape.owners[hit.faceIndex];
      const way = ways().get(shape.bodies[face]);
      picked({ surface: shape.surfaces[shape.patches[face]], point: minus(hit.point.toArray(), way) });
    } else if (hit !== undefined) {
      picked({ bolt: hit.object.userData.bolt });
    }
  });

  const slider = element("input", { type: "range", min: 0, max: 1, step: 0.05, value: apart, oninput: () => {
    apart = Number(slider.value);
    refresh();
  } });
  const turns = [["Turn left", "ArrowLeft"], ["Turn right", "ArrowRight"], ["Closer", "+"], ["Farther", "-"]];
  controls.append(
    element("label", { class: "control" }, "Bodies apart ", slider),
    ...turns.map(([text, key]) => button(text, () => Array.from({ length: key.startsWith("Arrow") ? 4 : 1 }, () => view.canvas.dispatchEvent(new KeyboardEvent("keydown", { key }))))),
    button("Whole model", () => view.look(boxOf(moved))),
  );
  if (count === 0) {
    host.append(element("p", { class: "told" }, "The surface has more triangles than a page draws, so that only edges are shown and nothing can be picked on it. The lists and fields do all the same."));
  }
  refresh();
  view.look(boxOf(moved));
  return {
    refresh,
    /** Marks a smooth surface as picked. */
    select(surface) {
      selected = surface?.number ?? null;
      refresh();
    },
    /** Shows a body or leaves it out. */
    show(body, isShown) {
      hidden[isShown ? "delete" : "add"](body);
      refresh();
    },
  };
}
