// Several runs on shared axes.

function showRuns({ runs }) {
  const state = makeState({ mode: 0 });
  const numbers = [...new Set(runs.flatMap((run) => run.modes.map(({ mode }) => mode)))].sort((a, b) => a - b);
  const groups = numbers.map((number) => ({
    name: String(number),
    curves: runs.flatMap((run, i) => {
      const place = run.modes.findIndex(({ mode }) => mode === number);
      if (place < 0) {
        return [];
      }
      const curves = modeCurves({ stops: [], ...run.modes[place] });
      // A colour per run, dashes per method.
      return curves.map((curve) => ({
        ...curve,
        name: curve.name === "CQSMA" ? run.name : `${run.name}, ${curve.name}`,
        colour: COLOURS[i % COLOURS.length],
      }));
    }),
  }));
  const responses = [...new Set(runs.map(({ response }) => response))];
  showBackbones(document.getElementById("live-curves"), groups, responses.join("; "), state);
}

document.documentElement.classList.add("is-live");
showRuns(JSON.parse(document.getElementById("data").textContent));
