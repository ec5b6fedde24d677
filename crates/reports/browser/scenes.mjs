// Scenes whose reports are tested: those that differ in what a report has to show.

const UNITS = { length: "m", mass: "kg", time: "s" };

/** A coarse Brake-Reuss beam with changes. */
function beam(changes) {
  return {
    units: UNITS,
    structure: { benchmark: "brake-reuss-beam" },
    model: { refinement: "quick" },
    interfaces: { gap: "flat", mu: 0.2, points_per_direction: 2 },
    analyses: { backbone: { amplitudes: 8, vertices_per_quarter: 4 } },
    ...changes,
  };
}

/** A bar on a plate that it touches at both ends, as a mesh of Gmsh 2.2 in metres. */
export function bridge() {
  const [columns, rows, size] = [12, 3, 0.01];
  const nodes = [];
  const lines = [];
  const numbers = new Map();
  // Bodies have nodes of their own where they touch.
  const node = (body, i, j, k) => {
    const key = `${body} ${i} ${j} ${k}`;
    if (!numbers.has(key)) {
      nodes.push([i * size, j * size, k * size]);
      numbers.set(key, nodes.length);
    }
    return numbers.get(key);
  };
  const add = (type, group, members) => lines.push(`${lines.length + 1} ${type} 2 ${group} ${group} ${members.join(" ")}`);
  const quad = (group, body, i, j, k, up) => {
    const around = [[0, 0], [1, 0], [1, 1], [0, 1]].map(([a, b]) => node(body, i + a, j + b, k));
    add(3, group, up ? around : around.reverse());
  };
  const isFoot = (i) => (i < 3 ? 3 : i >= columns - 3 ? 4 : null);
  for (let i = 0; i < columns; i += 1) {
    for (let j = 0; j < rows; j += 1) {
      for (const [body, k] of [[2, 0], [1, 1], [1, 2]]) {
        if (k === 1 && isFoot(i) === null) {
          continue;
        }
        const corners = [0, 1].flatMap((c) => [[0, 0], [1, 0], [1, 1], [0, 1]].map(([a, b]) => node(body, i + a, j + b, k + c)));
        add(5, body, corners);
      }
      if (isFoot(i) !== null) {
        quad(isFoot(i), 1, i, j, 1, false);
        quad(isFoot(i) + 2, 2, i, j, 1, true);
      }
      if (isFoot(i) !== null && j === 1 && (i === 1 || i === columns - 2)) {
        quad(i === 1 ? 7 : 9, 1, i, j, 3, true);
        quad(i === 1 ? 8 : 10, 2, i, j, 0, false);
      }
    }
  }
  const names = [[3, 1, "upper"], [3, 2, "lower"], [2, 3, "top left"], [2, 4, "top right"], [2, 5, "bottom left"], [2, 6, "bottom right"],
    [2, 7, "head left"], [2, 8, "nut left"], [2, 9, "head right"], [2, 10, "nut right"]];
  return gmsh(names, nodes, lines);
}

/** The text of a mesh of Gmsh 2.2. */
function gmsh(names, nodes, lines) {
  return [
    "$MeshFormat", "2.2 0 8", "$EndMeshFormat",
    "$PhysicalNames", names.length, ...names.map(([dimension, number, name]) => `${dimension} ${number} "${name}"`), "$EndPhysicalNames",
    "$Nodes", nodes.length, ...nodes.map((x, i) => `${i + 1} ${x.join(" ")}`), "$EndNodes",
    "$Elements", lines.length, ...lines, "$EndElements", "",
  ].join("\n");
}

/** Two plates that overlap, with two holes for bolts M8, as a mesh of Gmsh 2.2 in millimetres. One end has a name, the faces in contact have none. */
export function lap() {
  const [nodes, numbers, lines] = [[], new Map(), []];
  const node = (body, x) => {
    const key = `${body} ${x.map((v) => Math.round(1e6 * v)).join(" ")}`;
    if (!numbers.has(key)) {
      nodes.push(x);
      numbers.set(key, nodes.length);
    }
    return numbers.get(key);
  };
  const add = (type, group, members) => lines.push(`${lines.length + 1} ${type} 2 ${group} ${group} ${members.join(" ")}`);
  const [width, thickness, around, rings] = [40, 8, 16, 3];
  const rim = (i) => {
    // Points on the edge of a square of half the width, a quarter of each side apart.
    const [side, part] = [Math.floor((i % around) / 4), ((i % around) % 4) / 4];
    const [x, y] = [[1, 2 * part - 1], [1 - 2 * part, 1], [-1, 1 - 2 * part], [2 * part - 1, -1]][side];
    return [(x * width) / 2, (y * width) / 2];
  };
  const ring = (centre, i, j) => rim(i).map((v, c, [x, y]) => {
    const inner = (4.5 * v) / Math.hypot(x, y);
    return (c === 0 ? centre : 0) + inner + ((v - inner) * j) / rings;
  });
  [[1, [80, 200], 0], [2, [-120, 0], -thickness]].forEach(([body, [from, to], bottom]) => {
    const prism = (corners) => [0, 1].forEach((k) => add(5, body, [k, k + 1].flatMap((layer) => corners.map((x) => node(body, [...x, bottom + (layer * thickness) / 2])))));
    for (const centre of [20, 60]) {
      for (let i = 0; i < around; i += 1) {
        for (let j = 0; j < rings; j += 1) {
          prism([[i, j], [i, j + 1], [i + 1, j + 1], [i + 1, j]].map(([a, b]) => ring(centre, a, b)));
        }
      }
    }
    const step = (to - from) / 6;
    for (let i = 0; i < 6; i += 1) {
      for (let j = 0; j < 4; j += 1) {
        prism([[0, 0], [1, 0], [1, 1], [0, 1]].map(([a, b]) => [from + (i + a) * step, 10 * (j + b) - 20]));
        if (body === 2 && i === 0) {
          [0, 1].forEach((k) => add(3, 3, [[j, k], [j, k + 1], [j + 1, k + 1], [j + 1, k]].map(([a, b]) => node(body, [from, 10 * a - 20, bottom + (b * thickness) / 2]))));
        }
      }
    }
  });
  return gmsh([[3, 1, "upper"], [3, 2, "lower"], [2, 3, "end <i>"]], nodes, lines);
}

/** Scenes of which amplitudes do not converge. */
export const INCOMPLETE = new Set(["failed", "several"]);

/** What scenes are run with. */
export const ARGUMENTS = { uncertain: ["--samples", "20"] };

/** Six cases of two parameters. */
export const STUDY = {
  scene: beam({ analyses: { backbone: { amplitudes: 5, vertices_per_quarter: 2 } } }),
  parameters: { "/interfaces/mu": { values: [0.1, 0.2, 0.3] }, "/interfaces/gap": { values: ["flat", "measured"] } },
};

export const SCENES = {
  uncertain: beam({
    analyses: { backbone: { amplitudes: 4, vertices_per_quarter: 2 }, sensitivities: ["interfaces.mu", "bolts.load"] },
    uncertain: { parameters: { "interfaces.mu": { normal: { sd: 0.02 } } } },
  }),
  plain: beam({ analyses: { backbone: { amplitudes: 8, vertices_per_quarter: 4, methods: ["rqnma"] }, epmc: { harmonics: 3 } } }),
  single: beam({ analyses: { backbone: { amplitudes: 1, amplitude_from: 1e-4, amplitude_to: 1e-4, vertices_per_quarter: 2 } } }),
  failed: beam({ analyses: { backbone: { amplitudes: 2, vertices_per_quarter: 1, amplitude_to: 1e6 } } }),
  hostile: beam({
    name: "</script><script>document.title='broken'</script><img src=x onerror=alert(1)> & \"quoted\"",
    analyses: { backbone: { amplitudes: 2, vertices_per_quarter: 2 } },
  }),
  several: {
    units: UNITS,
    structure: { mesh: {
      path: "bridge.msh",
      interfaces: [{ name: "left <b>", top: "top left", bottom: "bottom left" }, { name: "right", top: "top right", bottom: "bottom right" }],
      bolts: [{ head: "head left", nut: "nut left" }, { head: "head right", nut: "nut right" }],
      response: { nearest: [0, 0, 0.03], direction: [0.36, 0.48, 0.8] },
    } },
    model: { material: { youngs_modulus: "200 GPa", poisson_ratio: 0.3, density: "7800 kg/m^3" } },
    interfaces: { surface: { benchmark: "brake-reuss-beam" }, gap: "flat", mu: 0.2 },
    bolts: { load: "2 kN" },
    analyses: {
      modes: { followed: [1, 2] },
      backbone: { amplitudes: 4, amplitude_from: "10 nm", amplitude_to: "20 um", vertices_per_quarter: 4 },
    },
  },
};
