// Curves on axes: values under the pointer, zoom, keyboard. Axes and zoom are uPlot's; curves need not be functions of x.

const REACH = 40;

/** The next number below or above that is 1, 2 or 5 times a power of ten. */
function roundLog(value, towards) {
  const power = 10 ** Math.floor(Math.log10(value) + 1e-9);
  const steps = [1, 2, 5, 10].map((step) => step * power);
  return towards === Math.floor ? steps.findLast((step) => step <= 1.0001 * value) ?? power : steps.find((step) => step >= 0.9999 * value) ?? 10 * power;
}

/** Smallest and largest of the values that an axis can show; a little apart where they are equal. */
function rangeOf(values, axis) {
  const shown = values.filter((v) => Number.isFinite(v) && (!axis.log || v > 0));
  if (shown.length === 0) {
    return axis.log ? [0.1, 1] : [0, 1];
  }
  const low = shown.reduce((a, b) => Math.min(a, b));
  const high = shown.reduce((a, b) => Math.max(a, b));
  if (axis.log) {
    const factor = Math.max((high / low) ** 0.05, 1.05);
    return axis.round ? [roundLog(low / factor, Math.floor), roundLog(high * factor, Math.ceil)] : [low / factor, high * factor];
  }
  const room = Math.max(0.06 * (high - low), 1e-3 * Math.max(Math.abs(low), Math.abs(high)), 1e-300);
  return [low - room, high + room];
}

/** Texts along an axis. */
function axisTexts(log) {
  return (_, values) => {
    const numbers = values.filter((v) => v !== null);
    const [low, high] = [Math.min(...numbers), Math.max(...numbers)];
    return values.map((value) => {
      if (value === null) {
        return "";
      }
      if (log) {
        const exponent = Math.floor(Math.log10(value) + 1e-9);
        const mantissa = value / 10 ** exponent;
        // The first mark is where the axis begins, which need not be round.
        if (![1, 2, 5].some((round) => Math.abs(mantissa - round) < 1e-6) || (mantissa > 1.5 && high / low > 1e3)) {
          return "";
        }
        return mantissa < 1.5 && (exponent < -2 || exponent > 3) ? powerOfTen(exponent) : readable(value, 1);
      }
      const digits = Math.min(Math.max(Math.ceil(Math.log10(Math.max(Math.abs(low), Math.abs(high)) / (high - low || 1))) + 2, 2), 9);
      return readable(value, digits);
    });
  };
}

/**
 * A chart in `host`. A specification has `label`, axes `x` and `y` ({label, log}), what is said where there are no values (`empty`), and `curves`: {name, colour, dash, marks, visible,
 * points: [{x, y, note}], band: [{x, low, high}]}. `picked` is told the curve and the number of a point that was clicked; `zoomed` is told
 * the range of x.
 */
function makeChart(host, { height = 300, picked = null, zoomed = null } = {}) {
  const area = element("div", { class: "chart", tabindex: 0, role: "group" });
  const readout = element("output", { class: "readout", "aria-live": "polite" });
  const marker = element("div", { class: "marker", hidden: true });
  host.append(area, readout);
  let spec = null;
  let plot = null;
  let full = null;
  let active = null;

  const drawn = () => spec.curves.filter((curve) => curve.visible !== false);
  const showable = (point) => point && point.x !== null && point.y !== null && Number.isFinite(point.x) && Number.isFinite(point.y)
    && (!spec.x.log || point.x > 0) && (!spec.y.log || point.y > 0);

  function place(x, y) {
    const ratio = uPlot.pxRatio;
    return [plot.valToPos(x, "x", true) / ratio, plot.valToPos(y, "y", true) / ratio];
  }

  function draw() {
    const { ctx } = plot;
    const ratio = uPlot.pxRatio;
    const box = plot.bbox;
    ctx.save();
    ctx.beginPath();
    ctx.rect(box.left, box.top, box.width, box.height);
    ctx.clip();
    if (!drawn().some((curve) => curve.points.some(showable))) {
      ctx.font = `${14 * ratio}px system-ui, sans-serif`;
      ctx.fillStyle = "#555";
      ctx.textAlign = "center";
      ctx.fillText(spec.empty ?? "no values", box.left + box.width / 2, box.top + box.height / 2);
    }
    const at = (x, y) => [plot.valToPos(x, "x", true), plot.valToPos(y, "y", true)];
    for (const curve of drawn()) {
      ctx.setLineDash([]);
      if (curve.band) {
        const edge = curve.band.filter((b) => showable({ x: b.x, y: b.low }) && showable({ x: b.x, y: b.high }));
        ctx.beginPath();
        edge.forEach((b) => ctx.lineTo(...at(b.x, b.low)));
        edge.toReversed().forEach((b) => ctx.lineTo(...at(b.x, b.high)));
        ctx.closePath();
        ctx.globalAlpha = 0.2;
        ctx.fillStyle = curve.colour;
        ctx.fill();
        ctx.globalAlpha = 1;
      }
      ctx.strokeStyle = curve.colour;
      ctx.fillStyle = curve.colour;
      ctx.lineWidth = 1.8 * ratio;
      ctx.lineJoin = "round";
      ctx.setLineDash((curve.dash ?? []).map((length) => length * ratio));
      ctx.beginPath();
      let pen = false;
      for (const point of curve.points) {
        if (!showable(point)) {
          pen = false;
        } else if (pen) {
          ctx.lineTo(...at(point.x, point.y));
        } else {
          ctx.moveTo(...at(point.x, point.y));
          pen = true;
        }
      }
      ctx.stroke();
      if (curve.marks) {
        ctx.setLineDash([]);
        for (const point of curve.points.filter(showable)) {
          const [x, y] = at(point.x, point.y);
          ctx.beginPath();
          ctx.arc(x, y, (point.strong ? 5 : 3) * ratio, 0, TURN);
          ctx.fill();
        }
      }
    }
    ctx.restore();
  }

  function activate(found) {
    active = found;
    if (found === null) {
      marker.hidden = true;
      readout.replaceChildren();
      return;
    }
    const point = found.curve.points[found.index];
    const [x, y] = place(point.x, point.y);
    const box = plot.bbox;
    marker.style.transform = `translate(${x - box.left / uPlot.pxRatio}px, ${y - box.top / uPlot.pxRatio}px)`;
    marker.style.borderColor = found.curve.colour;
    marker.hidden = false;
    const value = (axis, number) => `${axis.name ?? axis.label}: ${readable(number, 6)}${axis.unit ? ` ${axis.unit}` : ""}`;
    readout.replaceChildren(
      element("strong", {}, found.curve.name),
      `${point.note ? ` ${point.note}` : ""} \u2014 ${value(spec.x, point.x)}; ${value(spec.y, point.y)}`,
    );
  }

  /** The point nearest to a place in the plot (pixels). */
  function nearest(left, top) {
    const box = plot.bbox;
    const [px, py] = [left + box.left / uPlot.pxRatio, top + box.top / uPlot.pxRatio];
    let best = null;
    let closest = REACH;
    for (const curve of drawn()) {
      curve.points.forEach((point, index) => {
        if (showable(point)) {
          const [x, y] = place(point.x, point.y);
          const distance = Math.hypot(x - px, y - py);
          if (distance < closest) {
            closest = distance;
            best = { curve, index };
          }
        }
      });
    }
    return best;
  }

  function pick(found) {
    if (found !== null && picked !== null) {
      picked(found.curve, found.index);
    }
  }

  function step(along, across) {
    const curves = drawn().filter((curve) => curve.points.some(showable));
    if (curves.length === 0) {
      return;
    }
    const from = active === null ? -1 : curves.indexOf(active.curve);
    const curve = from < 0 ? curves[0] : curves[(from + across + curves.length) % curves.length];
    const shown = curve.points.map((point, index) => (showable(point) ? index : -1)).filter((index) => index >= 0);
    let index = shown[0];
    if (from >= 0 && across === 0) {
      const at = shown.indexOf(active.index);
      index = shown[Math.min(Math.max(at + along, 0), shown.length - 1)];
    } else if (from >= 0) {
      const { x } = active.curve.points[active.index];
      index = shown.reduce((a, b) => (Math.abs(curve.points[b].x - x) < Math.abs(curve.points[a].x - x) ? b : a));
    }
    activate({ curve, index });
  }

  /** Zooms by a factor about the active point or the middle. */
  function zoom(factor) {
    for (const key of ["x", "y"]) {
      const { log } = spec[key];
      const forth = log ? Math.log : (v) => v;
      const back = log ? Math.exp : (v) => v;
      const [low, high] = [forth(plot.scales[key].min), forth(plot.scales[key].max)];
      const centre = active === null ? 0.5 * (low + high) : forth(active.curve.points[active.index][key]);
      plot.setScale(key, { min: back(centre - (centre - low) * factor), max: back(centre + (high - centre) * factor) });
    }
  }

  function reset() {
    if (plot !== null) {
      plot.setScale("x", { min: full.x[0], max: full.x[1] });
      plot.setScale("y", { min: full.y[0], max: full.y[1] });
    }
  }

  function build() {
    plot?.destroy();
    active = null;
    readout.replaceChildren();
    const values = (key) => drawn().flatMap((curve) => [
      ...curve.points.filter(showable).map((point) => point[key]),
      ...(curve.band ?? []).flatMap((b) => (key === "x" ? [b.x] : [b.low, b.high])).filter((v) => v !== null),
    ]);
    full = { x: rangeOf(values("x"), spec.x), y: rangeOf(values("y"), spec.y) };
    area.setAttribute("aria-label", `${spec.label}. Arrow keys go from point to point and from curve to curve, plus and minus zoom, 0 resets.`);
    const axis = (key, side) => ({
      scale: key,
      side,
      label: spec[key].label,
      labelSize: 20,
      size: side === 3 ? 62 : 38,
      stroke: "#333",
      grid: { stroke: "#e4e4e4", width: 1 },
      ticks: { stroke: "#999", width: 1, size: 5 },
      font: "12px system-ui, sans-serif",
      labelFont: "13px system-ui, sans-serif",
      values: axisTexts(spec[key].log),
    });
    const scale = (key) => ({ time: false, auto: true, distr: spec[key].log ? 3 : 1, log: 10, range: (_, low, high) => (low === null ? full[key] : [low, high]) });
    plot = new uPlot({
      mode: 2,
      width: Math.max(area.clientWidth, 200),
      height,
      legend: { show: false },
      scales: { x: scale("x"), y: scale("y") },
      axes: [axis("x", 2), axis("y", 3)],
      series: [null, { paths: () => null, points: { show: false }, facets: [{ scale: "x", auto: true }, { scale: "y", auto: true }] }],
      cursor: {
        points: { show: false },
        drag: { x: true, y: true, uni: 12 },
        bind: { dblclick: () => () => reset() },
      },
      hooks: {
        draw: [draw],
        setCursor: [(u) => {
          if (u.cursor.left >= 0) {
            activate(nearest(u.cursor.left, u.cursor.top));
          }
        }],
        setScale: [(u, key) => {
          marker.hidden = true;
          if (key === "x" && zoomed !== null) {
            zoomed([u.scales.x.min, u.scales.x.max]);
          }
        }],
      },
    }, [null, [full.x, full.y]], area);
    plot.over.append(marker);
    plot.over.addEventListener("click", () => pick(active));
  }

  area.addEventListener("keydown", (event) => {
    const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    if (event.ctrlKey || event.altKey || event.metaKey) {
      return;
    }
    if (event.key in steps) {
      step(...steps[event.key]);
    } else if (event.key === "+" || event.key === "-") {
      zoom(event.key === "+" ? 0.7 : 1 / 0.7);
    } else if (event.key === "0" || event.key === "Escape") {
      reset();
    } else if (event.key === "Enter") {
      pick(active);
    } else {
      return;
    }
    event.preventDefault();
  });
  new ResizeObserver(() => {
    if (plot !== null && area.clientWidth > 0 && area.clientWidth !== plot.width) {
      plot.setSize({ width: area.clientWidth, height });
    }
  }).observe(area);

  return {
    update(next) {
      spec = next;
      build();
    },
    reset,
    /** Shows this range of x, if it does not already. */
    show([low, high]) {
      if (plot !== null && (plot.scales.x.min !== low || plot.scales.x.max !== high)) {
        plot.setScale("x", { min: low, max: high });
      }
    },
  };
}

/** A box to tick per curve, with a sample of its line; `changed` is called when one was ticked. */
function legend(curves, changed) {
  const entries = curves.map((curve) => {
    const line = svgElement("line", { x1: 0, y1: 6, x2: 28, y2: 6, stroke: curve.colour, "stroke-width": 2.5, "stroke-dasharray": (curve.dash ?? []).join(" ") });
    const sample = svgElement("svg", { width: 28, height: 12, "aria-hidden": "true" }, line);
    if (curve.marks) {
      sample.append(svgElement("circle", { cx: 14, cy: 6, r: 3.5, fill: curve.colour }));
    }
    const box = element("input", {
      type: "checkbox",
      checked: curve.visible !== false,
      onchange: () => {
        curve.visible = box.checked;
        changed();
      },
    });
    return element("label", { class: "control" }, box, sample, ` ${curve.name}`);
  });
  return element("div", { class: "legend", role: "group", "aria-label": "Curves" }, ...entries);
}
