// Brings a page about a run to life.

/** An amplitude in words. */
function stopLabel({ number, response_displacement: x }) {
  if (x === null) {
    return `amplitude ${number}`;
  }
  const scale = scaleOf(x, "m");
  return `amplitude ${number}: ${readable(x * scale.factor)} ${scale.unit}`;
}

function showRun(data) {
  const { modes } = data;
  const place = (name) => document.getElementById(`live-${name}`);
  const state = makeState({ mode: 0, stop: 0, field: "pressure", element: null });
  const groups = modes.map((mode) => ({
    name: `${mode.mode}, ${mode.frequency_hz.toFixed(2)} Hz`,
    curves: modeCurves(mode),
  }));

  const surface = data.interface === undefined ? null : readInterface(data.interface);
  const stops = modes.map((mode) => [
    { label: "prestress", number: 0, fields: surface?.prestress, loops: null },
    ...mode.stops.map((stop) => ({
      number: stop.number,
      label: stopLabel(stop),
      fields: readFields(stop.fields),
      loops: stop.loops ?? null,
    })),
  ]);
  const stopsOf = (mode) => stops[mode];

  if (groups.some((group) => group.curves.length > 0)) {
    showBackbones(place("curves"), groups, data.response, state, (curve, index) => {
      const stop = stops[state.values.mode].findIndex(({ number }) => number === index + 1);
      if (curve.name === "CQSMA" && stop > 0) {
        state.set({ stop });
      }
    });
  }
  if (data.forced !== undefined) {
    showForced(place("forced"), data.forced);
  }
  if (surface !== null) {
    // Modes may have their fields stored at different amplitudes.
    state.listen((changed) => {
      if (changed.includes("mode") && state.values.stop >= stops[state.values.mode].length) {
        state.set({ stop: stops[state.values.mode].length - 1 });
      }
    });
    if (modes.length > 1) {
      place("maps").append(modeChoice(groups, state));
    }
    showMaps(place("maps"), surface, stopsOf, state);
    if (modes.some((mode) => mode.stops.length > 0)) {
      showLoops(place("maps"), surface, stopsOf, state);
    }
    if (surface.positions) {
      showSpace(place("space"), surface, data.bodies, stopsOf, state);
    }
  }
  modes.forEach((mode, i) => place(`table-${i}`)?.append(downloadButton(mode.file, mode.table)));
}

// The scripts draw what is shown; should they fail, the pictures that are in the page come back.
document.documentElement.classList.add("is-live");
try {
  showRun(JSON.parse(document.getElementById("data").textContent));
} catch (error) {
  document.documentElement.classList.remove("is-live");
  throw error;
}
