// Mode shapes in space.

/** Share of the size of the structure that the largest displacement is drawn with. */
const LARGEST_DISPLACEMENT = 0.1;

function showShapes(host, { bodies, modes, left_out: leftOut }) {
  host.append(element("h2", {}, "In space"));
  if (!hasWebGL()) {
    host.append(element("p", { class: "told" }, "This browser has no WebGL, without which nothing can be drawn in space; the pictures below show the same modes."));
    return;
  }
  const rest = bodyPositions(bodies);
  const box = boxOf(rest);
  const size = Math.hypot(...box[0].map((v, c) => box[1][c] - v));
  const indices = arrayOf(Uint32Array, bodies.triangles === "" ? bodies.edges : bodies.triangles);
  const controls = element("div", { class: "controls", role: "group", "aria-label": "Mode" });
  host.append(controls);
  const view = makeView(host, "A mode shape in space", { box, ...upright(box) });
  const moved = new Float32Array(rest);
  const colours = new Float32Array(rest.length);
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(moved, 3));
  geometry.setAttribute("color", new THREE.BufferAttribute(colours, 3));
  geometry.setIndex(new THREE.BufferAttribute(indices, 1));
  view.scene.add(bodies.triangles === ""
    ? new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ vertexColors: true }))
    : new THREE.Mesh(geometry, new THREE.MeshLambertMaterial({ vertexColors: true, flatShading: true, side: THREE.DoubleSide })));
  view.scene.add(edgeLines(rest, arrayOf(Uint32Array, bodies.edges), 0x888888, 0.4));

  let displacement = null;
  let strength = 1;
  let playing = false;

  /** Draws the shape at a phase of its oscillation. */
  function draw(phase) {
    const factor = (strength * phase * LARGEST_DISPLACEMENT * size) / 32767;
    for (let i = 0; i < rest.length; i += 1) {
      moved[i] = rest[i] + factor * displacement[i];
    }
    geometry.attributes.position.needsUpdate = true;
    geometry.computeBoundingSphere();
    view.refresh();
  }

  function choose(index) {
    displacement = arrayOf(Int16Array, modes[index].displacement);
    const lengthsOf = [];
    for (let i = 0; i < displacement.length; i += 3) {
      lengthsOf.push(Math.hypot(displacement[i], displacement[i + 1], displacement[i + 2]));
    }
    const largest = lengthsOf.reduce((a, b) => Math.max(a, b), 0) || 1;
    const colour = new THREE.Color();
    lengthsOf.forEach((length, i) => {
      colour.setStyle(css(viridis(length / largest)));
      colours.set([colour.r, colour.g, colour.b], 3 * i);
    });
    geometry.attributes.color.needsUpdate = true;
    draw(1);
  }

  const play = button("Play", () => {
    playing = !playing;
    play.textContent = playing ? "Stop" : "Play";
    const start = performance.now();
    const frame = (now) => {
      if (playing) {
        draw(Math.cos((TURN * (now - start)) / 2000));
        requestAnimationFrame(frame);
      } else {
        draw(1);
      }
    };
    requestAnimationFrame(frame);
  });
  const slider = element("input", { type: "range", min: -1, max: 1, step: 0.05, value: 1, oninput: () => {
    strength = Number(slider.value);
    draw(1);
  } });
  controls.append(
    choice("Mode", modes.map(({ name }, i) => [i, name]), 0, (value) => choose(Number(value))),
    element("label", { class: "control" }, "Displacement ", slider),
    // Nothing moves for readers who want no motion; the slider shows the same.
    ...(matchMedia("(prefers-reduced-motion: reduce)").matches ? [] : [play]),
  );
  host.append(element("p", { class: "hint" }, `Colours are magnitudes of the displacement. Drag or use the arrow keys to turn, plus and minus to zoom.${leftOut > 0 ? ` ${leftOut} further modes have no room here.` : ""}`));
  choose(0);
}

document.documentElement.classList.add("is-live");
try {
  const data = JSON.parse(document.getElementById("data").textContent);
  if (data.modes.length > 0 && (data.bodies ?? null) !== null) {
    showShapes(document.getElementById("live-shapes"), data);
  }
} catch (error) {
  document.documentElement.classList.remove("is-live");
  throw error;
}
