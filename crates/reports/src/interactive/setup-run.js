// Saves the scene, runs it, and shows the backbone while it grows.

/** Time between two questions for progress (ms). */
const PAUSE = 250;

/** Sends something to the program, and gives the answer; what went wrong is its `error`. */
async function send(action, document) {
  const response = await fetch(action, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(document) });
  return response.ok ? response.json() : { error: `${response.status} ${response.statusText}` };
}

/** Seconds in words. */
function duration(seconds) {
  return seconds < 90 ? `${Math.max(1, Math.round(seconds))} s` : `${Math.round(seconds / 60)} min`;
}

/** Controls and pictures of runs in `host`; `complete()` says whether the scene can be run, `refused` is told messages about it. */
function showRun(host, form, facts, complete, refused) {
  const status = element("p", { class: "status", role: "status" });
  const asked = element("div", { class: "asked" });
  const bar = element("progress", { max: 1, value: 0, "aria-label": "Progress of the stage", hidden: true });
  const charts = element("div", { hidden: true });
  const answer = element("pre", { class: "answer", tabindex: 0, "aria-label": "Answer", hidden: true });
  const report = element("p", { hidden: true }, element("a", { href: "results/report.html", target: "_blank", rel: "noopener" }, "Open the report"));
  const log = element("ol", { class: "log" });
  const details = element("details", {}, element("summary", {}, "What the run says"), log);
  const save = button("Save", () => write("save"));
  const run = button("Run", () => write("run"), { class: "main" });
  const stop = button("Stop", () => send("stop", {}));
  const buttons = element("div", { class: "controls", role: "group", "aria-label": "Save and run" }, save, run, stop);
  host.append(buttons, element("p", { class: "hint" }, `The scene is saved as ${facts.scene_file}, results go to ${facts.results}.`), asked, status, bar, report, answer, charts, details);
  details.hidden = true;
  const [above, below] = [element("div"), element("div")];
  charts.append(above, below);
  const [frequencies, dampings] = [makeChart(above, { height: 220 }), makeChart(below, { height: 220 })];
  let curves = new Map();
  let running = false;
  let begun = false;

  function enable() {
    run.disabled = running || !complete();
    save.disabled = running;
    stop.disabled = !running;
    run.textContent = begun ? "Run again" : "Run";
  }

  /** Saves or runs the scene; `options` are what the reader agreed to. */
  async function write(action, options = {}) {
    asked.replaceChildren();
    const said = await send(action, { scene: form.text(), ...options });
    if (said.exists !== undefined) {
      asked.append(
        element("p", { class: "warning" }, `${said.exists} is there already, and this page has not written what is in it.`),
        button(`Replace ${said.exists}`, () => write(action, { ...options, replace: true })),
        button("Leave it", () => asked.replaceChildren()),
      );
      asked.querySelector("button").focus();
    } else if (said.saved === undefined) {
      status.textContent = said.error ?? "The scene is not complete.";
      refused(said.errors ?? []);
    } else if (action === "save") {
      status.textContent = `Saved as ${said.saved}.`;
    } else {
      follow();
    }
  }

  function draw() {
    const modes = [...curves];
    const chart = (name, unit, key) => ({
      label: `${name} against amplitude`,
      empty: "the first amplitude is on its way",
      x: { label: "amplitude at the response point [m]", name: "amplitude", unit: "m", log: true },
      y: { label: unit === "" ? `${name} [-]` : `${name} [${unit}]`, name, unit, log: key === "damping_ratio" },
      curves: modes.map(([mode, points], i) => ({
        name: `mode ${mode}`,
        colour: COLOURS[i % COLOURS.length],
        marks: true,
        points: points.map((point) => ({ x: point.amplitude_m, y: point[key] })).sort((a, b) => a.x - b.x),
      })),
    });
    frequencies.update(chart("frequency", "Hz", "frequency_hz"));
    dampings.update(chart("damping ratio", "", "damping_ratio"));
    charts.dataset.points = modes.reduce((sum, [, points]) => sum + points.length, 0);
  }

  function note(text, kind) {
    log.append(element("li", { class: kind }, text));
  }

  function take(event) {
    if (event.event === "point") {
      curves.set(event.mode, [...(curves.get(event.mode) ?? []), event]);
      return true;
    }
    if (event.event === "end") {
      note(`${event.stage}: ${event.seconds.toFixed(1)} s`, "stage");
    } else if (event.text) {
      note(event.text, event.event);
    }
    return false;
  }

  function showProgress({ stage, fraction, seconds_left: left }) {
    bar.value = fraction;
    status.textContent = `Running: ${stage}, ${Math.round(100 * fraction)} %${left === undefined || left === null ? "" : `, about ${duration(left)} left`}.`;
  }

  function conclude(end) {
    running = false;
    bar.hidden = true;
    answer.textContent = end.answer.trim();
    answer.hidden = end.answer === "";
    report.hidden = end.answer === "";
    status.textContent = end.code === 0 ? "Finished." : end.code === 3 ? "Finished, but not all amplitudes converged."
      : end.stopped ? "Stopped. What is finished is kept: Run again goes on from there." : `The run ended early. ${end.error}`;
    if (end.occupied) {
      asked.append(button("Replace the results there", () => write("run", { overwrite: true })));
    }
    enable();
  }

  /** Follows a run until its end, or that of the program. */
  function follow() {
    return listen().catch(() => {
      running = false;
      status.textContent = "The program does not answer any more; start it again.";
      enable();
    });
  }

  async function listen() {
    [running, begun] = [true, true];
    curves = new Map();
    log.replaceChildren();
    [bar.hidden, charts.hidden, details.hidden, answer.hidden, report.hidden] = [false, false, false, true, true];
    bar.removeAttribute("value");
    status.textContent = "Running.";
    enable();
    draw();
    let from = 0;
    for (;;) {
      const told = await (await fetch(`progress?from=${from}`)).json();
      from = told.next;
      if (told.events.filter(take).length > 0) {
        draw();
      }
      if (told.end !== null) {
        conclude(told.end);
        return;
      }
      if (told.progress !== null) {
        showProgress(told.progress);
      }
      await new Promise((resolve) => {
        setTimeout(resolve, PAUSE);
      });
    }
  }

  enable();
  return { enable, follow };
}
