// Frequency and damping against amplitude, and responses to forces.

const AMPLITUDES = {
  displacement: { name: "displacement amplitude", unit: "m" },
  velocity: { name: "velocity amplitude", unit: "m/s" },
  acceleration: { name: "acceleration amplitude", unit: "m/s\u00b2" },
  modal: { name: "modal amplitude", unit: "\u221akg m" },
};

/** The choice of the mode, which all sections of a page share. */
function modeChoice(groups, state) {
  const made = choice("Mode", groups.map((group, i) => [i, group.name]), state.values.mode, (value) => state.set({ mode: Number(value) }));
  state.listen(() => {
    made.querySelector("select").value = state.values.mode;
  });
  return made;
}

/** Frequency above damping. `groups` are lists of curves with a name each, of which one is shown; `picked` is told a curve and a point. */
function showBackbones(host, groups, response, state, picked = null) {
  const stored = groups.some((group) => group.curves.some((curve) => curve.strong?.includes(true)));
  const charts = element("div");
  const legendPlace = element("div");
  const told = element("p", { class: "told", role: "status" });
  const axes = { amplitude: "displacement", x: true, frequency: false, damping: true };
  const measured = [];
  const partner = { zoomed: null };
  const above = makeChart(charts, { height: 290, picked, zoomed: (range) => partner.damping?.show(range) });
  const below = makeChart(charts, { height: 290, picked, zoomed: (range) => partner.frequency?.show(range) });
  Object.assign(partner, { frequency: above, damping: below });

  const shown = () => [...groups[state.values.mode].curves, ...measured];

  function draw() {
    const { name, unit: plain } = AMPLITUDES[axes.amplitude];
    const amplitudes = shown().flatMap((curve) => curve[axes.amplitude]).filter((x) => x > 0);
    // The unit that suits the middle of a logarithmic axis.
    const middle = Math.sqrt(amplitudes.reduce((a, b) => Math.min(a, b), Infinity) * amplitudes.reduce((a, b) => Math.max(a, b), 0));
    const { factor, unit } = axes.amplitude === "modal" ? { factor: 1, unit: plain } : scaleOf(middle, plain);
    const x = { label: `${name} [${unit}]`, name, unit, log: axes.x };
    const scaled = (values, by) => values.map((value) => (value === null ? null : by * value));
    const chart = (key, label, [by, unit], log) => ({
      label: `${label} against ${name}`,
      empty: key === "damping" ? "no damping above what residuals may make of it" : "no values",
      x,
      y: { label: `${label} [${unit}]`, name: label, unit, log, round: true },
      curves: shown().map((curve) => ({
        ...curve,
        origin: curve,
        points: scaled(curve[key], by).map((y, i) => ({
          x: scaled([curve[axes.amplitude][i]], factor)[0],
          y,
          note: curve.notes?.[i] ?? "",
          strong: curve.strong?.[i],
        })),
        band: curve.bands?.map((band) => {
          const [low, , high] = scaled(band[key], by);
          return { x: factor * band[axes.amplitude], low, high };
        }),
      })),
    });
    above.update(chart("frequency", "frequency", [1, "Hz"], axes.frequency));
    below.update(chart("damping", "damping ratio", [100, "%"], axes.damping));
  }

  function renew() {
    legendPlace.replaceChildren(legend(shown(), draw));
    draw();
  }

  async function open(file) {
    if (file === undefined) {
      return;
    }
    try {
      const curve = backboneOf(await file.text());
      const colour = COLOURS[(1 + measured.length) % COLOURS.length];
      measured.push({ name: file.name, colour, marks: true, dash: [4, 3], ...curve });
      told.textContent = `${file.name}: ${curve.frequency.length} amplitudes.`;
      renew();
    } catch (error) {
      told.textContent = `${file.name}: ${error.message}.`;
    }
  }

  const file = element("input", { type: "file", accept: ".csv,text/csv", onchange: () => open(file.files[0]) });
  const controls = element(
    "div",
    { class: "controls", role: "group", "aria-label": "Axes" },
    choice("Amplitude", Object.entries(AMPLITUDES).map(([key, { name }]) => [key, name.replace(" amplitude", "")]), axes.amplitude, (value) => {
      axes.amplitude = value;
      draw();
    }),
    ...[["x", "log amplitude"], ["frequency", "log frequency"], ["damping", "log damping"]].map(([key, label]) => tick(label, axes[key], (value) => {
      axes[key] = value;
      draw();
    })),
    button("Reset zoom", () => [above, below].forEach((chart) => chart.reset())),
    element("label", { class: "control" }, "Open a measured backbone (CSV) ", file),
  );
  if (groups.length > 1) {
    controls.prepend(modeChoice(groups, state));
  }
  host.append(
    element("h2", {}, "Backbone"),
    controls,
    legendPlace,
    charts,
    told,
    element("p", { class: "hint" }, `Amplitudes are those of ${response || "the response point"}.${stored ? " Large dots have their fields stored." : ""} Drag to zoom, double-click to see all again.`),
  );
  state.listen((changed) => {
    if (changed.includes("mode")) {
      renew();
    }
  });
  renew();
}

/** The curves of a mode: those of the methods, and that of the run on top, with its bands. */
function modeCurves(mode) {
  const bands = mode.bands ?? [];
  const own = backboneOf(mode.table);
  const methods = mode.methods.map((method) => ({
    name: method.name,
    ...STYLES[method.name],
    ...withAmplitudes({ displacement: method.response_displacement, modal: method.modal_amplitude, frequency: method.frequency_hz, damping: method.damping_ratio }),
  }));
  const measured = (mode.measured ?? []).map((one, i) => ({
    name: one.name,
    colour: COLOURS[(1 + i) % COLOURS.length],
    marks: true,
    dash: [4, 3],
    ...withAmplitudes({ displacement: one.response_displacement, modal: one.modal_amplitude, frequency: one.frequency_hz, damping: one.damping_ratio }),
  }));
  const stored = new Set(mode.stops.map((stop) => stop.number));
  const run = { name: "CQSMA", ...STYLES.CQSMA, ...own };
  run.notes = own.frequency.map((_, i) => `amplitude ${i + 1}${stored.has(i + 1) ? ", with fields" : ""}`);
  run.strong = own.frequency.map((_, i) => stored.has(i + 1));
  if (bands.length > 0) {
    const known = own.modal.findIndex((value, i) => value !== null && own.displacement[i] > 0);
    const modal = known < 0 ? null : own.modal[known] / own.displacement[known];
    run.bands = bands.map((band) => {
      const omega = TURN * band.frequency_hz[1];
      const x = band.response_displacement;
      return { displacement: x, velocity: x * omega, acceleration: x * omega * omega, modal: modal === null ? null : modal * x, frequency: band.frequency_hz, damping: band.damping_ratio };
    });
  }
  const beside = [...methods, ...measured];
  return own.frequency.length > 0 ? [...beside, run] : beside;
}

/** Angles (degrees) without jumps of whole turns, the first one between -180 and 180. */
function unwrapped(angles) {
  let before = 0;
  return angles.map((angle) => {
    before = angle - 360 * Math.round((angle - before) / 360);
    return before;
  });
}

/** Amplitude above phase against the frequency of the force. */
function showForced(host, levels) {
  const charts = element("div");
  const partner = {};
  const above = makeChart(charts, { height: 320, zoomed: (range) => partner.phase?.show(range) });
  const below = makeChart(charts, { height: 220, zoomed: (range) => partner.amplitude?.show(range) });
  Object.assign(partner, { amplitude: above, phase: below });
  let log = true;
  const held = levels.some((level) => level.unit === "m");
  const shade = (i) => COLOURS[i % COLOURS.length];
  const curves = levels.flatMap((level, i) => {
    const name = `${readable(level.level)} ${level.unit}`;
    const forced = { name, colour: shade(i), f: level.frequency_hz, amplitude: level.amplitude, phase: unwrapped(level.phase) };
    if (level.alone.length === 0) {
      return [forced];
    }
    const [f, amplitude, phase] = [0, 1, 2].map((c) => level.alone.map((point) => point[c]));
    return [forced, { name: `${name}, mode alone`, colour: shade(i), dash: [6, 4], f, amplitude, phase: unwrapped(phase) }];
  });
  const draw = () => {
    const chart = (key, label, unit, scale) => ({
      label: `${label} against frequency`,
      x: { label: "frequency of the force [Hz]", name: "frequency", unit: "Hz", log: false },
      y: { label: `${label} [${unit}]`, name: label, unit, log: scale, round: true },
      curves: curves.map((curve) => ({ ...curve, points: curve[key].map((y, i) => ({ x: curve.f[i], y })) })),
    });
    above.update(held ? chart("amplitude", "amplitude of the force", "N", log) : chart("amplitude", "displacement amplitude", "m", log));
    below.update(chart("phase", "phase behind the force", "\u00b0", false));
  };
  const controls = element("div", { class: "controls", role: "group", "aria-label": "Axes" }, tick("log amplitude", log, (value) => {
    log = value;
    draw();
  }), button("Reset zoom", () => [above, below].forEach((chart) => chart.reset())));
  host.append(element("h3", {}, "Response to a harmonic force"), controls, legend(curves, draw), charts);
  draw();
}
