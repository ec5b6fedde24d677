// The interface between the bodies, in space.

/** Share of the size of the interface that the largest motion is drawn with. */
const LARGEST_MOTION = 0.12;

/** What of a vector is at right angles to another, with the length one. */
function orthogonal(vector, other) {
  const unit = other.clone().normalize();
  return vector.clone().addScaledVector(unit, -vector.dot(unit)).normalize();
}

/** The interface with the field of the map, moved by its relative motion; the bodies around it. */
function showSpace(host, surface, bodies, stopsOf, state) {
  host.append(element("h3", {}, "In space"));
  if (!hasWebGL()) {
    host.append(element("p", { class: "told" }, "This browser has no WebGL, without which nothing can be drawn in space; the map above shows the same fields."));
    return;
  }
  const { positions, elements, frames } = surface;
  const around = bodies === undefined ? positions : bodyPositions(bodies);
  const readout = element("output", { class: "readout", "aria-live": "polite" });
  const told = element("p", { class: "hint" });
  const controls = element("div", { class: "controls", role: "group", "aria-label": "View" });
  host.append(controls);
  const box = boxOf(positions);
  // The top body is above: the normal of the interface points into the bottom one.
  const normal = frames.length === 9 ? Array.from(frames.subarray(6, 9)) : [0, 1, 2].map((c) => frames.reduce((sum, v, i) => (i % 9 === 6 + c ? sum + v : sum), 0));
  const up = new THREE.Vector3(...normal).negate();
  const flat = upright(box);
  const { right } = Math.abs(up.dot(flat.right)) < 0.9 * up.length() ? flat : { right: flat.up };
  const view = makeView(host, "The interface and the bodies in space", up.lengthSq() > 0 ? { box, right: orthogonal(right, up), up: up.normalize() } : { box, ...flat });
  host.append(readout, told);

  // Triangles around the first node of each outline.
  const owner = [];
  const corners = [];
  elements.forEach((outline, i) => {
    for (let k = 1; k + 1 < outline.length; k += 1) {
      owner.push(i);
      corners.push(outline[0], outline[k], outline[k + 1]);
    }
  });
  const mesh = colouredMesh(new Float32Array(3 * corners.length), new Float32Array(3 * corners.length), new THREE.MeshBasicMaterial({ vertexColors: true, side: THREE.DoubleSide }));
  view.scene.add(mesh);
  let shell = [];
  if (bodies !== undefined) {
    const edges = edgeLines(around, arrayOf(Uint32Array, bodies.edges), 0x555555, 0.55);
    shell.push(edges);
    if (bodies.triangles !== "") {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.BufferAttribute(around, 3));
      geometry.setIndex(new THREE.BufferAttribute(arrayOf(Uint32Array, bodies.triangles), 1));
      shell.push(new THREE.Mesh(geometry, new THREE.MeshLambertMaterial({ color: 0x8fa3b5, flatShading: true, transparent: true, opacity: 0.16, depthWrite: false })));
    }
    view.scene.add(...shell);
  }
  const extent = Math.hypot(...box[0].map((v, c) => box[1][c] - v));
  let exaggeration = 0.5;
  let shown = null;

  /** Relative motion of the nodes since the prestress in the coordinates of the model (m): means of the elements around them. */
  function motions(fields) {
    const sums = new Float64Array(positions.length);
    const counts = new Float64Array(positions.length / 3);
    elements.forEach((outline, i) => {
      const frame = frames.length === 9 ? frames : frames.subarray(9 * i, 9 * i + 9);
      const local = [fields.motion_x[i], fields.motion_y[i], fields.interference[i] - surface.prestress.interference[i]];
      for (const node of outline) {
        counts[node] += 1;
        for (let c = 0; c < 3; c += 1) {
          sums[3 * node + c] += local[0] * frame[c] + local[1] * frame[3 + c] + local[2] * frame[6 + c];
        }
      }
    });
    return sums.map((sum, i) => sum / (counts[Math.floor(i / 3)] || 1));
  }

  function paint() {
    const { mode, stop, field } = state.values;
    const { fields, label } = stopsOf(mode)[stop];
    shown = coloursOf(surface, field, fields, []);
    const motion = motions(fields);
    let largest = 0;
    for (let node = 0; 3 * node < motion.length; node += 1) {
      largest = Math.max(largest, Math.hypot(motion[3 * node], motion[3 * node + 1], motion[3 * node + 2]));
    }
    const factor = largest > 0 ? (exaggeration * LARGEST_MOTION * extent) / largest : 0;
    const { position, color } = mesh.geometry.attributes;
    const colour = new THREE.Color();
    owner.forEach((i, triangle) => {
      colour.setStyle(shown.rgb(i));
      for (let k = 0; k < 3; k += 1) {
        const corner = 3 * triangle + k;
        const node = 3 * corners[corner];
        for (let c = 0; c < 3; c += 1) {
          position.array[3 * corner + c] = positions[node + c] + factor * motion[node + c];
        }
        color.array.set([colour.r, colour.g, colour.b], 3 * corner);
      }
    });
    position.needsUpdate = true;
    color.needsUpdate = true;
    mesh.geometry.computeBoundingSphere();
    told.textContent = `${FIELDS[field].name}, ${label}; colours as in the map. ${factor > 0
      ? `The motion of the top face against the bottom one since the prestress is drawn ${readable(factor, 2)} times as large.` : ""}`;
    view.refresh();
  }

  const ray = new THREE.Raycaster();
  /** The element under the pointer, or null. */
  function under(event) {
    const box = view.canvas.getBoundingClientRect();
    ray.setFromCamera(new THREE.Vector2((2 * (event.clientX - box.left)) / box.width - 1, 1 - (2 * (event.clientY - box.top)) / box.height), view.camera);
    const hit = ray.intersectObject(mesh)[0];
    return hit === undefined ? null : owner[hit.faceIndex];
  }
  view.canvas.addEventListener("pointermove", (event) => {
    if (event.buttons === 0) {
      const i = under(event);
      readout.textContent = i === null ? "" : elementText(surface, stopsOf(state.values.mode)[state.values.stop].fields, state.values.field, i, shown);
    }
  });
  let pressed = null;
  view.canvas.addEventListener("pointerdown", (event) => {
    pressed = [event.clientX, event.clientY];
  });
  view.canvas.addEventListener("click", (event) => {
    const i = under(event);
    if (i !== null && Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) < 4) {
      state.set({ element: i });
    }
  });

  const strength = element("input", { type: "range", min: 0, max: 1, step: 0.05, value: exaggeration, oninput: () => {
    exaggeration = Number(strength.value);
    paint();
  } });
  controls.append(element("label", { class: "control" }, "Motion ", strength));
  if (bodies !== undefined) {
    controls.append(tick("bodies", true, (value) => {
      shell.forEach((object) => {
        object.visible = value;
      });
      view.refresh();
    }), button("Interface", () => view.look(box)), button("Whole structure", () => view.look(boxOf(around))));
  }
  state.listen((changed) => {
    if (changed.some((key) => ["mode", "stop", "field"].includes(key))) {
      paint();
    }
  });
  paint();
}
