// Cases of a study: all backbones coloured by a parameter, and one of them by a slider.

/** The value of a parameter in words. */
function factorText(factor, value) {
  return value === null ? "\u2013" : factor.labels[value] ?? readable(value);
}

function showCases({ parameters, backbones, numbers }) {
  const host = document.getElementById("live-cases");
  const amplitudes = backbones.flat().map((at) => at.amplitude_m).filter((x) => x > 0);
  // The unit that suits the middle of a logarithmic axis.
  const scale = scaleOf(Math.sqrt(amplitudes.reduce((a, b) => Math.min(a, b), Infinity) * amplitudes.reduce((a, b) => Math.max(a, b), 0)), "m");
  const chosen = { by: 0, place: 0 };
  const charts = element("div", { class: "pair" });
  const partner = {};
  const told = element("p", { class: "told", role: "status" });
  const key = element("div", { class: "legend" });
  const slider = element("input", { type: "range", min: 0, max: backbones.length - 1, step: 1, value: 0, oninput: () => pick(Number(slider.value)) });
  const picked = (curve) => pick(curve.place);
  const [above, below] = [element("div"), element("div")];
  charts.append(above, below);
  partner.frequency = makeChart(above, { height: 320, picked, zoomed: (range) => partner.damping?.show(range) });
  partner.damping = makeChart(below, { height: 320, picked, zoomed: (range) => partner.frequency?.show(range) });

  const shades = () => {
    const { values } = parameters[chosen.by];
    const known = values.filter((value) => value !== null);
    const [low, high] = [Math.min(...known), Math.max(...known)];
    return { low, high, of: (value) => css(viridis(value === null || high === low ? 0.5 : (value - low) / (high - low))) };
  };

  function draw() {
    const shade = shades();
    const order = backbones.map((_, place) => place).filter((place) => place !== chosen.place);
    const x = { label: `amplitude [${scale.unit}]`, name: "amplitude", unit: scale.unit, log: true };
    const chart = (label, unit, log, value) => ({
      label: `${label} against amplitude`,
      x,
      y: { label: `${label} [${unit}]`, name: label, unit, log, round: true },
      curves: [...order, chosen.place].map((place) => ({
        name: `case ${numbers[place]}`,
        place,
        colour: place === chosen.place ? "#111" : shade.of(parameters[chosen.by].values[place]),
        marks: place === chosen.place,
        points: backbones[place].map((at) => ({ x: at.amplitude_m * scale.factor, y: value(at) })),
      })),
    });
    partner.frequency.update(chart("frequency", "Hz", false, (at) => at.frequency_hz));
    partner.damping.update(chart("damping", "%", true, (at) => (at.damping_ratio === null ? null : 100 * at.damping_ratio)));
    const known = [...new Set(parameters[chosen.by].values.filter((value) => value !== null))].sort((a, b) => a - b);
    const shown = known.length > 6 ? [shade.low, 0.5 * (shade.low + shade.high), shade.high] : known;
    key.replaceChildren(...shown.map((value) => {
      const sample = svgElement("svg", { width: 28, height: 12, "aria-hidden": "true" });
      sample.append(svgElement("line", { x1: 0, y1: 6, x2: 28, y2: 6, stroke: shade.of(value), "stroke-width": 3 }));
      return element("span", { class: "control" }, sample, factorText(parameters[chosen.by], value));
    }));
    const own = parameters.map((factor) => `${factor.name}: ${factorText(factor, factor.values[chosen.place])}`);
    const lacking = backbones[chosen.place].length === 0 ? "; no amplitude converged" : "";
    told.replaceChildren(element("strong", {}, `Case ${numbers[chosen.place]}`), ` \u2014 ${own.join("; ")}${lacking}`);
  }

  function pick(place) {
    chosen.place = place;
    slider.value = place;
    draw();
  }

  host.append(
    element("h2", {}, "Backbones of the cases"),
    element(
      "div",
      { class: "controls", role: "group", "aria-label": "Cases" },
      choice("Colour by", parameters.map(({ name }, i) => [i, name]), 0, (value) => {
        chosen.by = Number(value);
        draw();
      }),
      element("label", { class: "control" }, "Case ", slider),
      button("Reset zoom", () => Object.values(partner).forEach((chart) => chart.reset())),
    ),
    key,
    charts,
    told,
    element("p", { class: "hint" }, "The case of the slider is black; click a curve to choose it. Drag to zoom, double-click to see all again."),
  );
  draw();
}

document.documentElement.classList.add("is-live");
try {
  showCases(JSON.parse(document.getElementById("data").textContent));
} catch (error) {
  document.documentElement.classList.remove("is-live");
  throw error;
}
