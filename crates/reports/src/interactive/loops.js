// Hysteresis loops of single elements.

const STEPS = 4095;

/** What compressed bytes are. */
async function inflated(text) {
  const stream = new Blob([bytesOf(text)]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Reader of the loops of an amplitude: an element's motions since the prestress and tractions x, y, n, or null of an element that has none. */
async function readLoops(data) {
  const bytes = await inflated(data.sequences);
  const ranges = arrayOf(Float32Array, data.ranges);
  const recorded = (data.elements ?? null) === null ? null : arrayOf(Uint32Array, data.elements);
  const { vertices } = data;
  const all = bytes.length / 2;
  return (i) => {
    const place = recorded === null ? i : recorded.indexOf(i);
    if (place < 0) {
      return null;
    }
    const records = [];
    for (let component = 0; component < 6; component += 1) {
      const sequence = 6 * place + component;
      const [low, high] = [ranges[2 * sequence], ranges[2 * sequence + 1]];
      const values = new Float64Array(vertices);
      let step = 0;
      for (let k = 0; k < vertices; k += 1) {
        const at = sequence * vertices + k;
        const coded = bytes[at] + 256 * bytes[all + at];
        step += (coded >>> 1) ^ -(coded & 1);
        values[k] = low + (step * (high - low)) / STEPS;
      }
      records.push(values);
    }
    return { jump: records.slice(0, 3), traction: records.slice(3) };
  };
}

/** Unit vector along which a plane motion is largest. */
function mainDirection(x, y) {
  const mean = (values) => values.reduce((a, b) => a + b, 0) / values.length;
  const [mx, my] = [mean(x), mean(y)];
  let [xx, xy, yy] = [0, 0, 0];
  x.forEach((v, i) => {
    const [a, b] = [v - mx, y[i] - my];
    [xx, xy, yy] = [xx + a * a, xy + a * b, yy + b * b];
  });
  const angle = 0.5 * Math.atan2(2 * xy, xx - yy);
  return [Math.cos(angle), Math.sin(angle)];
}

/** Loops of the element and at the amplitude chosen. */
function showLoops(host, surface, stopsOf, state) {
  const told = element("p", { class: "told", role: "status" });
  const charts = element("div", { class: "pair" });
  const places = [element("div"), element("div")];
  charts.append(...places);
  host.append(element("h3", {}, "Loop of an element"), told, charts);
  const drawings = places.map((place) => makeChart(place, { height: 280 }));
  const readers = new Map();
  let wanted = 0;

  function chart(drawing, direction, jump, traction) {
    const extent = (values) => values.reduce((a, b) => Math.max(a, Math.abs(b)), 0);
    const [x, y] = [scaleOf(extent(jump), "m"), scaleOf(extent(traction), "Pa")];
    const axis = (name, { unit }) => ({ label: `${direction} ${name} [${unit}]`, name, unit, log: false });
    drawing.update({
      label: `${direction} traction against the motion since the prestress`,
      x: axis("motion", x),
      y: axis("traction", y),
      curves: [{
        name: "loop",
        colour: "#1f5d99",
        points: Array.from(jump, (v, i) => ({ x: v * x.factor, y: traction[i] * y.factor })),
      }],
    });
  }

  async function draw() {
    wanted += 1;
    const mine = wanted;
    const { element: i, mode, stop } = state.values;
    const { loops, label } = stopsOf(mode)[stop];
    let found = null;
    let text = "Click an element of the map, or choose one with the arrow keys.";
    if (i !== null && loops === null) {
      text = stop === 0 ? "The prestress has no loop: choose an amplitude." : "The loops of this amplitude were not recorded.";
    } else if (i !== null) {
      if (!readers.has(loops)) {
        readers.set(loops, readLoops(loops));
      }
      try {
        found = (await readers.get(loops))(i);
        text = "The loop of this element was not recorded; analyses.backbone.loops_at of the scene asks for it.";
      } catch (error) {
        text = `The loops cannot be read: ${error.message}.`;
      }
      if (mine !== wanted) {
        return;
      }
    }
    charts.hidden = found === null;
    if (found === null) {
      told.textContent = text;
      return;
    }
    const [x, y, n] = found.jump;
    const [tx, ty, tn] = found.traction;
    const direction = mainDirection(x, y);
    const along = (u, v) => u.map((value, k) => direction[0] * value + direction[1] * v[k]);
    const degrees = (Math.atan2(direction[1], direction[0]) * 180) / Math.PI;
    told.textContent = `Element ${i + 1}, ${label}. Motion is the jump less that of the prestress; tangential: along the largest motion, ${degrees.toFixed(0)}\u00b0 from the first direction of the interface.`;
    chart(drawings[0], "tangential", along(x, y), along(tx, ty));
    chart(drawings[1], "normal", n, tn);
  }

  state.listen((changed) => {
    if (changed.some((key) => ["element", "stop", "mode"].includes(key))) {
      draw();
    }
  });
  draw();
}
