// Pictures in space: a view that turns.

/** Whether the browser can draw in space. */
function hasWebGL() {
  const canvas = document.createElement("canvas");
  return Boolean(canvas.getContext("webgl2"));
}

/**
 * A view in `host` of what is added to its `scene`. It looks at the middle of a box of two corners, with the directions `right` and `up`
 * of its screen; it turns with the mouse and the arrow keys, and is drawn when something changed.
 */
function makeView(host, label, { box, right, up }) {
  const canvas = element("canvas", { class: "space", tabindex: 0, role: "img", "aria-label": `${label}. Arrow keys turn it, plus and minus zoom, 0 resets.` });
  // The axes of the model, in a corner.
  const arms = ["x", "y", "z"].map((name) => ({ line: svgElement("line", { x1: 40, y1: 40 }), text: svgElement("text", { "text-anchor": "middle" }, name) }));
  const tripod = svgElement("svg", { class: "tripod", viewBox: "0 0 80 80", "aria-hidden": "true" }, ...arms.flatMap(({ line, text }) => [line, text]));
  host.append(element("div", { class: "frame" }, canvas, tripod));
  const renderer = new THREE.WebGLRenderer({ canvas, antialias: true });
  renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
  renderer.setClearColor(0xffffff);
  const scene = new THREE.Scene();
  const camera = new THREE.PerspectiveCamera(30, 1, 1e-4, 1e4);
  const centre = new THREE.Vector3();
  let size = 1;
  const forward = new THREE.Vector3().crossVectors(right, up).normalize();
  const home = { azimuth: 0.5, elevation: 0.6, distance: 1.6 };
  const view = { ...home };
  let asked = false;

  scene.add(new THREE.AmbientLight(0xffffff, 2.2));
  const light = new THREE.DirectionalLight(0xffffff, 1.6);
  scene.add(light);

  function draw() {
    asked = false;
    const flat = Math.cos(view.elevation) * view.distance * size;
    camera.position.copy(centre)
      .addScaledVector(forward, flat * Math.cos(view.azimuth))
      .addScaledVector(right, flat * Math.sin(view.azimuth))
      .addScaledVector(up, Math.sin(view.elevation) * view.distance * size);
    camera.up.copy(up);
    camera.near = 0.01 * size;
    camera.far = 100 * size;
    camera.lookAt(centre);
    camera.updateProjectionMatrix();
    light.position.copy(camera.position);
    renderer.render(scene, camera);
    arms.forEach(({ line, text }, c) => {
      const arm = new THREE.Vector3(...[0, 1, 2].map((k) => (k === c ? 1 : 0))).applyQuaternion(camera.quaternion.clone().invert());
      const at = (length) => [40 + length * arm.x, 40 - length * arm.y];
      [["x2", 0], ["y2", 1]].forEach(([key, k]) => line.setAttribute(key, at(26)[k].toFixed(1)));
      [["x", 0, 0], ["y", 1, 5]].forEach(([key, k, shift]) => text.setAttribute(key, (at(35)[k] + shift).toFixed(1)));
    });
  }

  function refresh() {
    if (!asked) {
      asked = true;
      requestAnimationFrame(draw);
    }
  }

  function turn(azimuth, elevation, zoom = 1) {
    view.azimuth += azimuth;
    view.elevation = Math.min(Math.max(view.elevation + elevation, -1.55), 1.55);
    view.distance = Math.min(Math.max(view.distance * zoom, 0.1), 30);
    refresh();
  }

  let dragged = null;
  canvas.addEventListener("pointerdown", (event) => {
    dragged = [event.clientX, event.clientY];
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (dragged !== null) {
      turn(-0.008 * (event.clientX - dragged[0]), 0.008 * (event.clientY - dragged[1]));
      dragged = [event.clientX, event.clientY];
    }
  });
  canvas.addEventListener("pointerup", () => {
    dragged = null;
  });
  canvas.addEventListener("wheel", (event) => {
    // The page scrolls until the view is chosen.
    if (document.activeElement === canvas) {
      event.preventDefault();
      turn(0, 0, Math.exp(0.001 * event.deltaY));
    }
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    const keys = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1], "+": [0, 0, 0.85], "-": [0, 0, 1 / 0.85] };
    if (event.ctrlKey || event.altKey || event.metaKey) {
      return;
    }
    if (event.key in keys) {
      turn(...keys[event.key]);
    } else if (event.key === "0") {
      Object.assign(view, home);
      refresh();
    } else {
      return;
    }
    event.preventDefault();
  });
  new ResizeObserver(() => {
    const width = canvas.clientWidth;
    if (width > 0) {
      const height = Math.round(Math.min(0.6 * width, 520));
      renderer.setSize(width, height, false);
      canvas.style.height = `${height}px`;
      camera.aspect = width / height;
      // A narrow view needs more distance for the same width.
      camera.fov = camera.aspect < 1.4 ? 40 : 30;
      draw();
    }
  }).observe(canvas);

  /** Looks at the middle of a box, so that it is seen as a whole. */
  function look([low, high]) {
    size = Math.hypot(...low.map((v, c) => high[c] - v)) || 1;
    centre.set(...low.map((v, c) => 0.5 * (v + high[c])));
    Object.assign(view, home);
    refresh();
  }
  look(box);
  return { scene, camera, canvas, refresh, look };
}

/** Right and up of a screen that shows a box with its longest extent to the right and its shortest one upwards. */
function upright([low, high]) {
  const order = [0, 1, 2].sort((a, b) => high[b] - low[b] - (high[a] - low[a]));
  const axis = (c) => new THREE.Vector3(...[0, 1, 2].map((k) => (k === c ? 1 : 0)));
  return { right: axis(order[0]), up: axis(order[2]) };
}

/** A mesh of triangles with a colour per corner: `positions` and `colours` are its arrays. */
function colouredMesh(positions, colours, material) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(positions, 3));
  geometry.setAttribute("color", new THREE.BufferAttribute(colours, 3));
  return new THREE.Mesh(geometry, material);
}

/** Positions of a surface's nodes (m), three numbers each. */
function bodyPositions(bodies) {
  return Float32Array.from(arrayOf(Int16Array, bodies.positions), (v, i) => bodies.origin[i % 3] + v * bodies.step);
}

/** Corners of the box around positions. */
function boxOf(positions) {
  const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
  positions.forEach((v, i) => {
    low[i % 3] = Math.min(low[i % 3], v);
    high[i % 3] = Math.max(high[i % 3], v);
  });
  return [low, high];
}

/** Lines between nodes. */
function edgeLines(positions, edges, colour, opacity) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(positions, 3));
  geometry.setIndex(new THREE.BufferAttribute(edges, 1));
  return new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color: colour, transparent: true, opacity }));
}
