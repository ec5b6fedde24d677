// Fields over the interface: one colour per element.

const REGIMES = [
  { name: "stick", colour: "#0072b2", pattern: null },
  { name: "slip", colour: "#e69f00", pattern: "M0 8L8 0" },
  { name: "open", colour: "#f4f4f4", pattern: "M4 3.5v1" },
];

/** What a map shows: a name, a unit, and the values of an amplitude's fields; `at` is null of the prestress. */
const FIELDS = {
  regime: { name: "regime", unit: "" },
  pressure: { name: "pressure", unit: "Pa", values: (at) => at.pressure },
  traction: { name: "tangential traction", unit: "Pa", values: (at) => lengths(at.traction_x, at.traction_y) },
  flux: { name: "dissipated energy per area and cycle", unit: "J/m\u00b2", values: (at) => at.flux },
  motion: { name: "tangential motion since the prestress", unit: "m", values: (at) => lengths(at.motion_x, at.motion_y) },
  approach: { name: "approach since the prestress", unit: "m", values: (at, before) => at.interference.map((v, i) => v - before.interference[i]) },
  gap: { name: "gap (negative: interference)", unit: "m", values: (at) => at.interference.map((v) => -v) },
  slip: { name: "slipping share of the area", unit: "-", values: (at) => at.slip },
  open: { name: "open share of the area", unit: "-", values: (at) => at.open },
};

function lengths(x, y) {
  return x.map((v, i) => Math.hypot(v, y[i]));
}

/** Number of the regime in which most of an element is. */
function regimeOf(fields, i) {
  return fields.open[i] >= 0.5 ? 2 : fields.slip[i] >= 0.5 ? 1 : 0;
}

/** The interface of a page's data, with arrays in the place of text. */
function readInterface(data) {
  const corners = arrayOf(Uint32Array, data.corners);
  const nodes = arrayOf(Uint32Array, data.nodes);
  let first = 0;
  const elements = Array.from(corners, (n) => {
    first += n;
    return nodes.subarray(first - n, first);
  });
  const plane = arrayOf(Float32Array, data.plane);
  const centres = elements.map((outline) => [0, 1].map((c) => outline.reduce((sum, node) => sum + plane[2 * node + c], 0) / outline.length));
  const named = data.parts.length > 0 ? data.parts : [["interface", elements.length]];
  let start = 0;
  const positions = data.positions && arrayOf(Float32Array, data.positions);
  const frames = arrayOf(Float32Array, data.frames);
  const parts = named.map(([name, count]) => {
    start += count;
    return { name, from: start - count, to: start };
  });
  const surface = { elements, plane, centres, parts, positions, frames, prestress: readFields(data.prestress) };
  for (const part of parts) {
    const own = parts.length > 1 && positions ? partAxes(surface, part) : null;
    part.axes = own ?? data.axes.map(([factor, name]) => ({ factor, name, shift: 0 }));
    part.view = own === null ? data.view : `to the right is ${own[0].direction}, upwards ${own[1].direction}`;
  }
  return surface;
}

/**
 * Axes of one of several parts, which lie side by side in one plane: what is added to a coordinate there, and then multiplies it, and the
 * name of the result. Null of a curved part.
 */
function partAxes({ elements, plane, positions, frames }, { from, to }) {
  const frame = (i) => (frames.length === 9 ? frames : frames.subarray(9 * i, 9 * i + 9));
  const first = frame(from);
  for (let i = from; i < to; i += 1) {
    if (frame(i).some((v, k) => Math.abs(v - first[k]) > 1e-5)) {
      return null;
    }
  }
  const node = elements[from][0];
  return [0, 1].map((c) => {
    const row = Array.from(first.subarray(3 * c, 3 * c + 3));
    const along = row.reduce((sum, v, k) => sum + v * positions[3 * node + k], 0);
    const parallel = row.findIndex((v) => Math.abs(v) > 1 - 1e-6);
    const direction = `(${row.map((v) => Number(v.toFixed(3)) + 0).join(", ")})`;
    return {
      factor: parallel < 0 ? 1e3 : 1e3 * Math.sign(row[parallel]),
      name: parallel < 0 ? `along ${direction} [mm]` : `${"xyz"[parallel]} [mm]`,
      shift: along - plane[2 * node + c],
      direction,
    };
  });
}

function readFields(data) {
  return Object.fromEntries(Object.entries(data).map(([key, text]) => [key, arrayOf(Float32Array, text)]));
}

/** Numbers of an amplitude's element and what they are called. */
function elementText(surface, fields, key, i, shared) {
  const { axes } = surface.parts.find(({ to }) => i < to);
  const [x, y] = axes.map(({ factor, name, shift }, c) => `${name.replace(" [mm]", "")} ${(factor * (surface.centres[i][c] + shift)).toFixed(2)} mm`);
  const place = `Element ${i + 1} at ${x}, ${y}`;
  const share = (v) => `${(100 * v).toFixed(0)} %`;
  if (key === "regime") {
    return `${place}: ${REGIMES[regimeOf(fields, i)].name}; ${share(fields.slip[i])} of it slips, ${share(fields.open[i])} is open`;
  }
  const { name, unit } = FIELDS[key];
  const value = shared.values[i];
  const scale = scaleOf(Math.abs(value), unit);
  return `${place}: ${name} ${unit === "-" ? share(value) : `${readable(value * scale.factor)} ${scale.unit}`}`;
}

/** Values, range and colours of a field at an amplitude; the range is that of all `others` too. */
function coloursOf(surface, key, fields, others) {
  if (key === "regime") {
    const regimes = Array.from(fields.slip, (_, i) => regimeOf(fields, i));
    return { values: regimes, rgb: (i) => REGIMES[regimes[i]].colour };
  }
  const of = (at) => FIELDS[key].values(at, surface.prestress);
  const values = of(fields);
  let [low, high] = [Infinity, -Infinity];
  for (const all of [values, ...others.map(of)]) {
    for (const v of all) {
      if (Number.isFinite(v)) {
        [low, high] = [Math.min(low, v), Math.max(high, v)];
      }
    }
  }
  const range = high > low ? high - low : 1;
  return { values, low, high, rgb: (i) => (Number.isFinite(values[i]) ? css(viridis((values[i] - low) / range)) : "#fff") };
}

/** Multiples of 1, 2 or 5 times a power of ten between two values: about `n` of them, with their texts. */
function roundNumbers(from, to, n) {
  const rough = Math.abs(to - from) / n;
  if (!(rough > 0 && Number.isFinite(rough))) {
    return [];
  }
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((f) => f * power).find((s) => s >= 0.999 * rough) ?? 10 * power;
  const decimals = Math.min(Math.max(-Math.floor(Math.log10(step)), 0), 9);
  const numbers = [];
  for (let i = Math.ceil(Math.min(from, to) / step - 1e-6); i <= Math.floor(Math.max(from, to) / step + 1e-6); i += 1) {
    numbers.push([i * step, (i * step).toFixed(decimals)]);
  }
  return numbers;
}

/** The map with its controls. State: `mode`, `stop` (0 is the prestress), `field`, `element`. */
function showMaps(host, surface, stopsOf, state) {
  const [LEFT, MARGIN, BELOW] = [64, 14, 46];
  let width = 800;
  const picture = svgElement("svg", { class: "map", role: "group", tabindex: 0, "font-family": "sans-serif", "font-size": 14 });
  const readout = element("output", { class: "readout", "aria-live": "polite" });
  const stopText = element("output", { class: "stop" });
  const hint = element("p", { class: "hint" });
  const slider = element("input", { type: "range", min: 0, step: 1, oninput: () => state.set({ stop: Number(slider.value) }) });
  let part = 0;
  let shared = false;
  let paths = [];
  let shown = null;

  const inPart = () => surface.parts[part];
  const fieldsNow = () => stopsOf(state.values.mode)[state.values.stop].fields;

  function describe(i) {
    readout.textContent = i === null ? "" : elementText(surface, fieldsNow(), state.values.field, i, shown);
  }

  /** Outlines and axes: what does not change with the amplitude. */
  function build() {
    const { from, to } = inPart();
    const nodes = new Set(surface.elements.slice(from, to).flatMap((outline) => Array.from(outline)));
    // As many units as the place has pixels, so that texts keep their size.
    width = Math.min(Math.max(host.clientWidth, 320), 1200);
    let [left, right, bottom, top] = [Infinity, -Infinity, Infinity, -Infinity];
    for (const node of nodes) {
      const [x, y] = [surface.plane[2 * node], surface.plane[2 * node + 1]];
      [left, right, bottom, top] = [Math.min(left, x), Math.max(right, x), Math.min(bottom, y), Math.max(top, y)];
    }
    const scale = Math.min((width - LEFT - MARGIN) / (right - left), 520 / (top - bottom));
    const floor = MARGIN + scale * (top - bottom);
    const end = LEFT + scale * (right - left);
    const across = (x) => LEFT + scale * (x - left);
    const down = (y) => MARGIN + scale * (top - y);
    const barTop = floor + BELOW + 12;
    picture.setAttribute("viewBox", `0 0 ${width} ${barTop + 60}`);
    picture.replaceChildren();
    const patterns = REGIMES.map(({ colour, pattern }, i) => svgElement(
      "pattern",
      { id: `regime-${i}`, width: 8, height: 8, patternUnits: "userSpaceOnUse" },
      svgElement("rect", { width: 8, height: 8, fill: colour }),
      ...(pattern === null ? [] : [svgElement("path", { d: pattern, stroke: "#333", "stroke-width": 0.7 })]),
    ));
    picture.append(svgElement("defs", {}, ...patterns));
    paths = [];
    const cells = svgElement("g", {});
    for (let i = from; i < to; i += 1) {
      const points = Array.from(surface.elements[i], (node) => `${across(surface.plane[2 * node]).toFixed(2)} ${down(surface.plane[2 * node + 1]).toFixed(2)}`);
      const path = svgElement("path", { d: `M${points.join("L")}z`, "data-element": i });
      paths.push(path);
      cells.append(path);
    }
    picture.append(cells);
    let axes = `M${LEFT} ${MARGIN}V${floor.toFixed(1)}H${end.toFixed(1)}`;
    const texts = [];
    const text = (content, attributes) => texts.push(svgElement("text", attributes, content));
    const [toRight, up] = inPart().axes;
    const named = (axis, v) => axis.factor * (v + axis.shift);
    for (const [value, label] of roundNumbers(named(toRight, left), named(toRight, right), Math.max((end - LEFT) / 90, 3))) {
      const x = across(value / toRight.factor - toRight.shift).toFixed(1);
      axes += `M${x} ${floor.toFixed(1)}v5`;
      text(label, { x, y: floor + 20, "text-anchor": "middle" });
    }
    for (const [value, label] of roundNumbers(named(up, bottom), named(up, top), Math.max((floor - MARGIN) / 90, 4))) {
      const y = down(value / up.factor - up.shift);
      axes += `M${LEFT} ${y.toFixed(1)}h-5`;
      text(label, { x: LEFT - 8, y: y + 5, "text-anchor": "end" });
    }
    const middle = 0.5 * (MARGIN + floor);
    text(toRight.name, { x: 0.5 * (LEFT + end), y: floor + 40, "text-anchor": "middle" });
    text(up.name, { x: 16, y: middle, "text-anchor": "middle", transform: `rotate(-90 16 ${middle})` });
    picture.append(
      svgElement("path", { d: axes, fill: "none", stroke: "#444" }),
      ...texts,
      svgElement("g", { id: "bar", transform: `translate(${LEFT} ${barTop})` }),
      svgElement("path", { id: "chosen", fill: "none", stroke: "#d00", "stroke-width": 3, "pointer-events": "none" }),
    );
    hint.textContent = `Means over the elements, at the positive peak of the loop; ${inPart().view}. Click an element for its loop.`;
    paint();
  }

  function bar(key) {
    const length = width - LEFT - MARGIN;
    const place = picture.querySelector("#bar");
    const text = (content, attributes) => svgElement("text", attributes, content);
    if (key === "regime") {
      place.replaceChildren(...REGIMES.flatMap(({ name }, i) => [
        svgElement("rect", { x: 85 * i, y: 0, width: 28, height: 18, fill: `url(#regime-${i})`, stroke: "#777" }),
        text(name, { x: 85 * i + 36, y: 14 }),
      ]), text("what most of an element does", { x: 0, y: 44 }));
      return;
    }
    const { name, unit } = FIELDS[key];
    const scale = scaleOf(Math.max(Math.abs(shown.low), Math.abs(shown.high)), unit);
    const steps = Array.from({ length: 64 }, (_, i) => svgElement("rect", { x: (length * i) / 64, y: 0, width: length / 64 + 0.5, height: 14, fill: css(viridis((i + 0.5) / 64)) }));
    const numbers = [0, 0.25, 0.5, 0.75, 1].map((at) => text(
      readable((shown.low + at * (shown.high - shown.low)) * scale.factor, 3),
      { x: length * at, y: 32, "text-anchor": at === 0 ? "start" : at === 1 ? "end" : "middle" },
    ));
    place.replaceChildren(...steps, ...numbers, text(`${name} [${scale.unit}]`, { x: length / 2, y: 52, "text-anchor": "middle" }));
  }

  /** Colours of the field and the amplitude chosen. */
  function paint() {
    const stops = stopsOf(state.values.mode);
    const { field } = state.values;
    slider.max = stops.length - 1;
    slider.value = state.values.stop;
    const { label, fields } = stops[state.values.stop];
    slider.setAttribute("aria-valuetext", label);
    stopText.textContent = label;
    shown = coloursOf(surface, field, fields, shared ? stops.map((stop) => stop.fields) : []);
    paths.forEach((path, k) => {
      const i = inPart().from + k;
      const fill = field === "regime" ? `url(#regime-${shown.values[i]})` : shown.rgb(i);
      path.setAttribute("fill", fill);
      path.setAttribute("stroke", field === "regime" ? "#999" : fill);
    });
    picture.setAttribute("aria-label", `Map of ${FIELDS[field].name} at ${label}. Arrow keys choose an element, page up and down the amplitude.`);
    bar(field);
    choose();
  }

  function choose() {
    const { element: i } = state.values;
    const path = i === null ? undefined : paths[i - inPart().from];
    picture.querySelector("#chosen").setAttribute("d", path?.getAttribute("d") ?? "");
    describe(i);
  }

  /** The element that lies next in a direction. */
  function next(i, [dx, dy]) {
    const [x, y] = surface.centres[i];
    let [best, closest] = [i, Infinity];
    for (let j = inPart().from; j < inPart().to; j += 1) {
      const [u, v] = [surface.centres[j][0] - x, surface.centres[j][1] - y];
      const [along, beside] = [u * dx + v * dy, Math.abs(u * dy - v * dx)];
      const cost = along + 2.5 * beside;
      if (along > Math.abs(beside) && cost < closest) {
        [best, closest] = [j, cost];
      }
    }
    return best;
  }

  picture.addEventListener("pointermove", (event) => {
    const { element: under } = event.target.dataset;
    describe(under === undefined ? state.values.element : Number(under));
  });
  picture.addEventListener("pointerleave", () => describe(state.values.element));
  picture.addEventListener("click", (event) => {
    const { element: under } = event.target.dataset;
    if (under !== undefined) {
      state.set({ element: Number(under) });
    }
  });
  picture.addEventListener("keydown", (event) => {
    const directions = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    if (event.ctrlKey || event.altKey || event.metaKey) {
      return;
    }
    if (event.key in directions) {
      const { element: i } = state.values;
      const outside = i === null || i < inPart().from || i >= inPart().to;
      state.set({ element: outside ? Math.floor(0.5 * (inPart().from + inPart().to)) : next(i, directions[event.key]) });
    } else if (event.key === "PageUp" || event.key === "PageDown") {
      const stop = state.values.stop + (event.key === "PageUp" ? 1 : -1);
      state.set({ stop: Math.min(Math.max(stop, 0), Number(slider.max)) });
    } else {
      return;
    }
    event.preventDefault();
  });

  const fields = Object.entries(FIELDS).map(([key, { name }]) => [key, name]);
  const controls = element(
    "div",
    { class: "controls", role: "group", "aria-label": "Map" },
    choice("Field", fields, state.values.field, (field) => state.set({ field })),
    element("label", { class: "control wide-control" }, "Amplitude ", slider, " ", stopText),
    tick("same colours at all amplitudes", shared, (value) => {
      shared = value;
      paint();
    }),
  );
  if (surface.parts.length > 1) {
    controls.prepend(choice("Interface", surface.parts.map(({ name }, i) => [i, name]), part, (value) => {
      part = Number(value);
      build();
    }));
  }
  host.append(controls, picture, readout, hint);
  state.listen((changed) => {
    if (changed.some((key) => ["mode", "stop", "field"].includes(key))) {
      paint();
    } else if (changed.includes("element")) {
      choose();
    }
  });
  build();
  new ResizeObserver(() => {
    if (host.clientWidth > 0 && Math.min(Math.max(host.clientWidth, 320), 1200) !== width) {
      build();
    }
  }).observe(host);
}
