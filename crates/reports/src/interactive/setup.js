// A joint that is set up from its mesh: forms, model and runs on one page.

/** Time after the last change until the program is asked what it says (ms). */
const WAIT = 300;

/** The scene that a mesh proposes. */
function proposal(facts) {
  const bolts = facts.bolts.filter((bolt) => bolt.filled_by === null);
  const units = facts.systems[facts.length];
  const size = (bolt) => bolt.sizes[facts.length] ?? undefined;
  return {
    ...(units === undefined ? {} : { units }),
    structure: { mesh: {
      path: facts.mesh,
      interfaces: facts.touching.filter((pair) => pair.flat).map((pair) => pair.entry),
      bolts: bolts.map((bolt) => ({ axis: bolt.axis, size: size(bolt) })),
      response: { mode: 1 },
    } },
    interfaces: { gap: "flat" },
    analyses: { modes: { followed: [1] }, backbone: { amplitudes: 8, amplitude_from: "0.1 um", amplitude_to: "100 um" } },
  };
}

function showSetup(host, { facts, shape: raw }) {
  const shape = readShape(raw);
  // A page that is loaded again goes on where it was.
  const kept = sessionStorage.getItem(location.pathname);
  const scene = kept === null ? facts.scene ?? proposal(facts) : JSON.parse(kept);
  const mesh = "structure.mesh";
  let verdict = { complete: false, errors: [] };
  let pick = null;
  let run = null;
  let model = { refresh: () => {}, select: () => {} };
  let drawn = "";
  const changed = () => {
    sessionStorage.setItem(location.pathname, form.text());
    const shown = JSON.stringify([scene.structure, scene.analyses?.forced]);
    if (shown !== drawn) {
      drawn = shown;
      model.refresh();
    }
    ask();
  };
  const form = makeForm(scene, facts.schema, changed);
  const number = (text) => readable(text, 5);
  const nameOf = (body) => facts.bodies[body].name;

  // What the program says of the scene: of its fields at once after each change, of the structure when it has read the mesh.
  const said = element("div", { class: "said", role: "status", "aria-live": "polite" });
  const lines = element("ul", { class: "lines" });
  const check = async (fields) => {
    const answer = await send("check", { scene: form.text(), fields }).catch(() => ({ error: "The program does not answer any more; start it again." }));
    return answer.error === undefined ? answer : { complete: false, errors: [{ field: null, message: answer.error }] };
  };
  let version = 0;
  let timer = 0;
  let isReading = false;
  function ask() {
    version += 1;
    verdict = { ...verdict, complete: false };
    run?.enable();
    clearTimeout(timer);
    timer = setTimeout(question, WAIT);
  }
  async function question() {
    const own = version;
    const found = await check(true);
    if (own === version) {
      tell({ ...found, complete: false, echo: verdict.echo }, true);
      read();
    }
  }
  /** One question at a time; what has changed since is asked again. */
  async function read() {
    if (isReading) {
      return;
    }
    isReading = true;
    const own = version;
    const found = await check(false);
    isReading = false;
    if (own === version) {
      tell(found, false);
    } else {
      read();
    }
  }
  function tell(found, isOfFields) {
    verdict = found;
    host.classList.toggle("stale", isOfFields);
    const homeless = form.showMessages(verdict.errors);
    const open = verdict.errors.length;
    said.replaceChildren(
      element("p", {}, element("strong", {}, verdict.complete ? "The scene is complete." : open === 0 ? "The mesh is being read." : open === 1 ? "One thing is missing or wrong." : `${open} things are missing or wrong.`), open === 0 ? "" : " Each is told beside its field."),
      ...homeless.map(({ message }) => element("p", { class: "wrong" }, message)),
    );
    const echo = verdict.echo ?? {};
    const item = (kind) => (text) => element("li", { class: kind }, text);
    lines.replaceChildren(...(echo.warnings ?? []).map(item("warning")), ...(echo.lines ?? []).map(item("line")), ...(echo.notes ?? []).map(item("note")));
    bodies.forEach(({ told }, body) => {
      const mass = echo.masses?.[body];
      told.textContent = mass === undefined ? "" : `${number(mass)} kg`;
    });
    const used = interfaces.all.filter((row) => row.used);
    used.forEach((row) => {
      const own = (echo.areas ?? []).filter(({ name }) => used.length === 1 || name === row.entry.name || name.startsWith(`${row.entry.name}.`));
      row.told.textContent = own.length === 0 ? "" : `${number(1e6 * own.reduce((sum, { area }) => sum + area, 0))} mm\u00b2`;
    });
    bolts.all.filter((row) => row.used).forEach((row, i) => {
      const own = (echo.seats ?? []).filter(({ bolt }) => bolt === i + 1);
      row.told.textContent = own.length === 0 ? "" : own.map(({ side, covered }) => `${side} covered to ${Math.round(100 * covered)} %`).join(", ");
    });
    run?.enable();
  }

  // Unit of length and bodies.
  const lengths = facts.lengths.map((length) => [facts.systems[length], length]);
  const unit = form.field("units", "Unit of length of the mesh", { needed: true, choices: lengths, written: (units) => {
    bolts.all.filter((row) => row.sizes !== undefined).forEach((row) => {
      row.entry.size = row.sizes[units?.length] ?? undefined;
    });
    bolts.write();
  } });
  const bodies = facts.bodies.map(({ name, elements }, body) => {
    const swatch = element("span", { class: "swatch", "aria-hidden": "true" });
    swatch.style.background = `#${bodyColour(body).getHexString()}`;
    const told = element("span", { class: "echo" });
    const box = tick("", true, (shown) => model.show?.(body, shown));
    box.append(swatch, ` ${name} `, element("span", { class: "hint" }, elements), " ", told);
    return { told, box };
  });

  // Interfaces, bolts, supports.
  const pairRows = facts.touching.map(({ about, flat, entry }) => ({
    entry,
    used: false,
    text: about.replaceAll("`", ""),
    reason: flat ? undefined : "The faces look in all directions, as those of a thread or a pin: no interface can be made of them.",
  }));
  const sameBodies = (a, b) => JSON.stringify([...(a.between ?? [])].sort()) === JSON.stringify([...(b.between ?? [])].sort()) && b.between !== undefined;
  const interfaces = makeRows(form, `${mesh}.interfaces`, pairRows, sameBodies);
  const boltRows = facts.bolts.map(({ axis, diameter, sizes, filled_by: filled }) => ({
    entry: { axis, size: sizes[scene.units?.length] ?? undefined },
    used: false,
    sizes,
    radius: 0.5 * diameter,
    text: `hole of ${number(diameter)}, from (${textOf(axis[0])}) to (${textOf(axis[1])})`,
    reason: filled === null ? undefined : `${filled} is in the holes: glue it to what it presses on by ties in the scene, or leave it out of the mesh.`,
  }));
  const sameAxis = (a, b) => JSON.stringify(a.axis) === JSON.stringify(b.axis) && b.axis !== undefined;
  const bolts = makeRows(form, `${mesh}.bolts`, boltRows, sameAxis, (row, path) => [
    ...(row.sizes === undefined && row.entry.axis !== undefined ? [form.field(`${path}.axis.0`, "Axis from (head)"), form.field(`${path}.axis.1`, "Axis to (nut)")] : []),
    form.field(`${path}.size`, "Size", { needed: true, such: "M8" }),
    form.field(`${path}.washers`, "Washers"),
    form.field(`${path}.seat`, "Seat"),
  ]);
  const addBolt = (axis) => bolts.add({ entry: { axis, size: undefined }, used: true, text: "a bolt of yours" });
  const [, surfaces, points] = facts.groups;
  const held = [...surfaces.map(([name]) => ["surface", name]), ...points.map(([name]) => ["points", name])];
  const supports = makeRows(
    form,
    `${mesh}.supports`,
    held.map(([kind, name]) => ({ entry: { [kind]: name }, used: false, text: kind === "surface" ? name : `${name} (group of nodes)` })),
    (a, b) => a.surface === b.surface && a.points === b.points && JSON.stringify(a.face) === JSON.stringify(b.face),
    (row) => [element("div", { class: "controls", role: "group", "aria-label": "Directions that are held" }, ...["x", "y", "z"].map((name, c) => tick(`hold ${name}`, (row.entry.components ?? [true, true, true])[c], (value) => {
      row.entry.components = (row.entry.components ?? [true, true, true]).map((old, k) => (k === c ? value : old));
      supports.write();
    })))],
  );

  // Response and force.
  const responses = { mode: { mode: 1 }, nearest: { nearest: ["", "", ""], direction: [0, 0, 1] }, node: { node: "", direction: [0, 0, 1] } };
  const responseFields = element("div");
  const kindOf = () => ["nearest", "node"].find((kind) => kind in (form.at(`${mesh}.response`) ?? {})) ?? "mode";
  function drawResponse() {
    const kind = kindOf();
    responseKind.querySelector("select").value = kind;
    const direction = kind === "mode" ? [] : [form.field(`${mesh}.response.direction`, "Direction", { needed: true })];
    responseFields.replaceChildren(form.field(`${mesh}.response.${kind}`, kind === "mode" ? "Mode" : kind === "node" ? "Node" : "Position", { needed: true }), ...direction);
  }
  const respond = (response) => {
    form.put(`${mesh}.response`, response);
    drawResponse();
  };
  const responseKind = choice("Amplitudes are measured", [["mode", "where a mode moves most"], ["nearest", "at the node nearest to a position"], ["node", "at a node by its number or group"]], kindOf(), (kind) => respond(structuredClone(responses[kind])));
  const forceFields = element("div");
  const forced = "analyses.forced";
  function drawForce() {
    const fields = [["levels", "Amplitudes of the force", "10 N, 20 N"], ["node", "Node", ""], ["direction", "Direction", ""], ["from_hz", "From (Hz)", ""], ["to_hz", "To (Hz)", ""]];
    forceTick.querySelector("input").checked = form.at(forced) !== undefined;
    forceFields.replaceChildren(...(form.at(forced) === undefined ? [] : fields.map(([name, label, such]) => form.field(`${forced}.${name}`, label, { such }))));
  }
  const forceTick = tick("also the response to a harmonic force", false, (value) => {
    form.put(forced, value ? {} : undefined);
    drawForce();
  });
  const force = (node, direction) => {
    form.put(forced, { ...(form.at(forced) ?? {}), node: String(shape.labels[node]), direction });
    drawForce();
  };

  // The surface and what else a mesh cannot tell.
  const names = facts.benchmarks.map((name) => [name, name]);
  const files = element("datalist", { id: "files" }, ...facts.files.map((name) => element("option", { value: name })));
  const at = "interfaces.surface";
  const face = (side, label) => [[`ra`, "Ra", "0.8 um"], ["rsm", "Rsm", "80 um"], ["process", "Process", ""]].map(([name, text, such]) => form.field(`${at}.finish.${side}.${name}`, `${label}: ${text}`, { such }));
  const kinds = {
    benchmark: [{ benchmark: "" }, "measured surface of a benchmark", () => [form.field(`${at}.benchmark`, "Benchmark", { needed: true, choices: names })]],
    scans: [{ scans: ["", ""] }, "scans of both faces", () => [0, 1].map((side) => form.field(`${at}.scans.${side}`, side === 0 ? "Top face" : "Bottom face", { needed: true, such: "file in the folder of the scene", list: "files" }))],
    finish: [{ finish: { top: {}, bottom: {} } }, "finish of a drawing", () => [...face("top", "Top face"), ...face("bottom", "Bottom face"), form.field(`${at}.finish.flatness`, "Flatness of each face", { such: "10 um" })]],
    parameters: [{ parameters: { per: "interface", sets: [{ curves: { elastic: { normal_stiffness: "", tangential_stiffness: ["", ""] } } }] } }, "stiffness of the contact", () => [["normal_stiffness", "4e13 Pa/m"], ["tangential_stiffness", "3e13 Pa/m, 3e13 Pa/m"]].map(([name, such]) => form.field(`${at}.parameters.sets.0.curves.elastic.${name}`, name.replace("_", " "), { needed: true, such }))],
  };
  const surfaceFields = element("div");
  const surfaceKind = () => Object.keys(kinds).find((kind) => form.at(at)?.[kind] !== undefined) ?? "";
  const drawSurface = () => surfaceFields.replaceChildren(...(kinds[surfaceKind()]?.[2]() ?? []));
  const known = surfaceKind() !== "" || form.at(at) === undefined ? [] : [["own", textOf(form.at(at))]];
  const surfaceChoice = choice("The faces are known by", [["", "choose"], ...Object.entries(kinds).map(([kind, [, text]]) => [kind, text]), ...known], known.length > 0 ? "own" : surfaceKind(), (kind) => {
    form.put(at, kind in kinds ? structuredClone(kinds[kind][0]) : undefined);
    if (kind === "parameters") {
      form.put("interfaces.gap", undefined);
    }
    form.refresh();
    drawSurface();
  });
  const gaps = [["flat", "flat faces"], ["scan", "that of the scans"], ...names.map(([name]) => [{ benchmark: name }, `measured, of ${name}`])];

  // What is picked of the model.
  const pickText = element("p", { class: "told", role: "status" });
  const pickButtons = element("div", { class: "controls", role: "group", "aria-label": "What the picked face is to be" });
  const ordered = shape.surfaces.filter(Boolean).sort((a, b) => a.body - b.body || b.area - a.area);
  const faceText = ({ body, normal, flat, area, centre }) => `${nameOf(body)}: ${flat ? `plane, normal (${textOf(normal.map((v) => Number(v.toPrecision(3))))})` : "curved"}, about (${textOf(centre.map((v) => Number(v.toPrecision(4))))}), area ${number(area)}`;
  const faceChoice = choice("Face", [["", "none picked"], ...ordered.map((surface) => [surface.number, faceText(surface)])], "", (key) => {
    const surface = shape.surfaces[Number(key)];
    picked(key === "" ? {} : { surface, point: surface.centre });
  });
  const isPoint = (x) => Array.isArray(x) && x.length === 3 && x.every((v) => typeof v === "number");
  /** The smooth surface that an entry holds by a position on it. */
  const heldSurface = ({ face }) => (isPoint(face) ? shape.surfaces[shape.patches[shape.faceNear(shape.patches.keys(), face)]] : undefined);
  const nameFor = (surface) => shape.named.filter(({ faces }) => Array.from(surface.faces).some((one) => faces.has(one))).sort((a, b) => a.faces.size - b.faces.size)[0];
  function picked({ bolt, surface, point }) {
    pick = bolt !== undefined ? { row: bolts.all.filter((row) => row.entry.axis !== undefined)[bolt] } : surface === undefined ? null : { surface, node: shape.nearest(surface.nodes, point) };
    model.select(surface);
    faceChoice.querySelector("select").value = surface?.number ?? "";
    drawPick("");
  }
  /** A button that does something with what is picked, and keeps the focus. */
  function then(text, act, done = text) {
    return button(text, () => {
      act();
      drawPick(`${done}: done. `);
      [...pickButtons.children].find((one, i) => one.textContent === text || i === 0)?.focus();
    });
  }
  function drawPick(told) {
    if (pick === null) {
      pickText.textContent = "Click a face or a bolt in the picture, or choose a face from the list.";
      pickButtons.replaceChildren();
      return;
    }
    if (pick.row !== undefined) {
      const { row } = pick;
      pickText.textContent = `${told}Bolt: ${row.text}. ${row.reason ?? ""}`;
      pickButtons.replaceChildren(...(row.reason === undefined ? [then(row.used ? "Leave the bolt out" : "Take the bolt", () => bolts.set(row, !row.used))] : []));
      return;
    }
    const { surface, node } = pick;
    const point = shape.at(node);
    const rows = [...surface.pairs].map((pair) => interfaces.all[pair]);
    const named = nameFor(surface);
    const support = supports.all.find((row) => (row.entry.surface === named?.name && named !== undefined) || heldSurface(row.entry) === surface);
    const holdHere = () => supports.add({ entry: { face: shape.middle(shape.faceNear(surface.faces, point)) }, used: true, text: `the face at (${textOf(point)})` });
    // A bolt clamps what its axis meets, and what lies on that without a gap.
    const depth = 0.02 * lengthOf(minus(...boxOf(shape.positions)));
    pickButtons.replaceChildren(
      ...rows.filter((row) => row.reason === undefined).map((row) => then(`${row.used ? "No interface" : "Interface"}: ${row.entry.name}`, () => interfaces.set(row, !row.used))),
      ...(support === undefined ? [then("Hold this face", holdHere)] : [then(`${support.used ? "Do not hold" : "Hold"} ${support.text}`, () => supports.set(support, !support.used))]),
      then("Response here", () => respond({ nearest: point, direction: surface.normal })),
      then("Force here", () => force(node, surface.normal)),
      ...(surface.flat ? [then("Bolt through here", () => addBolt([point, point.map((v, c) => Number((v - depth * surface.normal[c]).toPrecision(6)))]))] : []),
    );
    const lacks = [
      rows.length === 0 ? "It touches no other body, so that it is no interface." : `It is part of ${rows.map((row) => row.entry.name).join(", ")}.`,
    ];
    pickText.textContent = `${told}${faceText(surface)}. Nearest node: ${shape.labels[node]}, at (${textOf(point)}). ${lacks.join(" ")}`.trim();
  }

  const key = (colour, text) => {
    const swatch = element("span", { class: "swatch", "aria-hidden": "true" });
    swatch.style.background = colour;
    return element("span", { class: "control" }, swatch, text);
  };
  const picture = element("div");
  const viewPart = element("section", { class: "view" }, element("h2", {}, "Model"), picture, element("div", { class: "legend" }, key(USED, "interface"), key(UNUSED, "touches, not used"), key(PICKED, "picked"), key(HELD, "held"), key(BOLT, "bolt"), key(RESPONSE, "response"), key(FORCE, "force")), faceChoice, element("div", { class: "picked" }, pickText, pickButtons));

  const notes = facts.notes.length === 0 ? [] : [element("details", {}, element("summary", {}, "Notes about the file"), element("ul", {}, ...facts.notes.map((note) => element("li", {}, note))))];
  const forms = element(
    "div",
    { class: "forms", role: "form", "aria-label": "Scene" },
    form.section("Mesh", mesh, unit, element("div", { class: "rows", role: "group", "aria-label": "Bodies that are shown" }, ...bodies.map(({ box }) => box)), ...notes),
    form.section("Interfaces", `${mesh}.interfaces`, interfaces.host, ...(facts.touching.length === 0 ? [element("p", { class: "hint" }, "No two bodies touch within a twentieth of an edge.")] : [])),
    form.section("Contact", "interfaces", form.field("interfaces.mu", "Friction coefficient", { needed: true, such: "0.2" }), form.field("interfaces.gap", "Gap", { choices: gaps })),
    form.section("Surface", at, surfaceChoice, files, surfaceFields),
    form.section("Bolts", `${mesh}.bolts`, bolts.host, button("Add a bolt", () => addBolt([["", "", ""], ["", "", ""]]))),
    form.section("Bolt load", "bolts", form.field("bolts.load", "Tension of each bolt", { needed: form.at("bolts.torque") === undefined && form.at("bolts.loads") === undefined, such: "10 kN" }), form.field("bolts.behaviour", "Behaviour")),
    form.section("Material", "model", ...[["youngs_modulus", "Young's modulus", "200 GPa"], ["poisson_ratio", "Poisson ratio", "0.3"], ["density", "Density", "7850 kg/m^3"]].map(([name, label, such]) => form.field(`model.material.${name}`, label, { needed: true, such }))),
    form.section("Supports", `${mesh}.supports`, supports.host, element("p", { class: "hint" }, "Nothing holds the structure but what is ticked. A face without a name is held by picking it in the picture.")),
    form.section("Response", `${mesh}.response`, responseKind, responseFields),
    form.section("Analyses", "analyses", form.field("analyses.modes.followed", "Modes followed", { such: "1, 3" }), ...[["amplitudes", "Number of amplitudes"], ["amplitude_from", "Smallest amplitude"], ["amplitude_to", "Largest amplitude"]].map(([name, label]) => form.field(`analyses.backbone.${name}`, label)), forceTick, forceFields),
  );
  const runPart = element("section", { class: "run" }, element("h2", {}, "Check and run"), said);
  host.append(viewPart, forms, runPart);
  run = showRun(runPart, form, facts, () => verdict.complete, (errors) => errors.length > 0 && tell({ complete: false, errors }, false));
  runPart.append(element("details", { open: true }, element("summary", {}, "What the program reads"), lines));
  drawResponse();
  drawForce();
  drawSurface();
  drawPick("");

  /** What of the scene is marked in the picture. */
  function marks() {
    const response = form.at(`${mesh}.response`) ?? {};
    const load = form.at(forced) ?? {};
    const arrow = (node, direction, colour, into) => ({ at: shape.at(node), direction: direction.map((v) => v / lengthOf(direction)), colour, into, body: shape.nodeBody[node] });
    const arrows = [];
    const node = (label) => shape.labels.indexOf(Number(label));
    const place = isPoint(response.nearest) ? shape.nearest(shape.labels.keys(), response.nearest) : node(response.node);
    if (place >= 0 && isPoint(response.direction)) {
      arrows.push(arrow(place, response.direction, RESPONSE, false));
    }
    if (node(load.node) >= 0 && isPoint(load.direction)) {
      arrows.push(arrow(node(load.node), load.direction, FORCE, true));
    }
    const names = supports.all.filter((row) => row.used).map((row) => row.entry.surface);
    const axes = bolts.all.filter((row) => row.entry.axis !== undefined);
    return {
      interfaces: new Set(pairRows.map((row, pair) => (row.used ? pair : -1))),
      supports: new Set([
        ...shape.named.filter(({ name }) => names.includes(name)).flatMap(({ faces }) => Array.from(faces)),
        ...supports.all.filter((row) => row.used).flatMap((row) => Array.from(heldSurface(row.entry)?.faces ?? [])),
      ]),
      bolts: axes.map(({ entry: { axis }, radius, used }) => ({ axis: axis.every(isPoint) ? axis : [[0, 0, 0], [0, 0, 0]], radius: 0.9 * (radius ?? 0.01 * lengthOf(boxOf(shape.positions)[1])), used })),
      arrows,
    };
  }
  model = { ...model, ...showModel(picture, shape, facts, marks, picked) };
  form.refresh();
  question();
  fetch("progress?from=0").then((response) => response.json()).then((told) => told !== null && run.follow());
}

document.documentElement.classList.add("is-live");
showSetup(document.getElementById("setup"), JSON.parse(document.getElementById("data").textContent));
