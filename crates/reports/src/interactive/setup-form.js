// Forms of a scene, made from its JSON Schema. What is wrong with a field is said by the program, and shown beside it.

const BLOCKS = ["units", "name", "accuracy", "structure", "model", "interfaces", "bolts", "background_damping", "uncertain", "analyses", "output"];

/** A value as it stands in a field, and back; numbers are numbers, and what has a unit is text. */
function textOf(value) {
  return Array.isArray(value) ? value.map(textOf).join(", ") : String(value ?? "");
}

function valueOf(text, types) {
  const one = (part) => (!types.includes("string") || types.includes("number") || types.includes("array")) && part !== "" && Number.isFinite(Number(part)) ? Number(part) : part;
  return types.includes("array") ? text.split(",").map((part) => one(part.trim())) : one(text.trim());
}

/** The schema of the field at a path of names and numbers, with what a reference stands for. */
function schemaAt(schema, path) {
  const resolved = (node) => {
    if (node?.$ref !== undefined) {
      return resolved({ ...schema.$defs[node.$ref.split("/").at(-1)], ...node, $ref: undefined });
    }
    const some = node?.anyOf?.filter((other) => other.type !== "null");
    return some?.length === 1 ? resolved({ ...some[0], ...node, anyOf: undefined }) : node;
  };
  const step = (node, key) => {
    const whole = resolved(node);
    const own = whole?.properties?.[key] ?? (/^\d+$/.test(key) ? whole?.items : undefined);
    return own ?? [...(whole?.oneOf ?? []), ...(whole?.anyOf ?? [])].reduce((found, other) => found ?? step(other, key), undefined);
  };
  return resolved(path.split(".").reduce(step, schema)) ?? {};
}

/** A path as forms have it, of one that a message names. */
function plainPath(path) {
  return path.replace(/\[(\d+)\]/g, ".$1").replace(/, number (\d+)/g, (_, number) => `.${Number(number) - 1}`);
}

/** A scene with the fields that show it; `changed` is called after every change. */
function makeForm(scene, schema, changed) {
  let fields = [];
  let count = 0;

  const at = (path) => path.split(".").reduce((place, key) => place?.[key], scene);

  /** Writes a value, or takes it out where it is `undefined`. */
  function put(path, value) {
    const keys = path.split(".");
    const last = keys.pop();
    let place = scene;
    for (const key of keys) {
      place[key] ??= {};
      place = place[key];
    }
    if (value === undefined && !Array.isArray(place)) {
      delete place[last];
    } else {
      place[last] = value ?? "";
    }
    changed();
  }

  /** Shows a message in a place that has a path of the scene, and tells the control so. */
  function register(path, host, control, refresh) {
    const id = control?.id ?? `place-${(count += 1)}`;
    const message = element("p", { class: "wrong", id: `${id}-wrong`, hidden: true });
    host.append(message);
    host.dataset.path = path;
    const field = { path, host, control, message, refresh };
    fields.push(field);
    return field;
  }

  /** A field for what is at a path. Its help is the description in the schema; `choices` are pairs of value and text. */
  function field(path, label, { choices = null, needed = false, such = "", list = null, written = () => {} } = {}) {
    const node = schemaAt(schema, path);
    const types = [node.type ?? []].flat();
    const id = `field-${(count += 1)}`;
    const constants = node.oneOf?.every((one) => "const" in one) ? node.oneOf.map((one) => [one.const, one.const]) : null;
    const offered = choices ?? constants;
    const isTick = types.includes("boolean");
    const write = (value) => {
      put(path, value);
      refresh();
      written(value);
    };
    const common = { id, "aria-describedby": `${id}-help ${id}-wrong`, "aria-required": needed ? "true" : null };
    const control = offered !== null
      ? element("select", { ...common, onchange: () => write(control.value === "" ? undefined : JSON.parse(control.value)) })
      : isTick
        ? element("input", { ...common, type: "checkbox", onchange: () => write(control.checked || undefined) })
        : element("input", { ...common, type: "text", autocomplete: "off", spellcheck: "false", placeholder: such, list, oninput: () => write(control.value.trim() === "" ? undefined : valueOf(control.value, types)) });
    const mark = element("span", { class: "needed" }, "needed");
    const help = element("p", { class: "hint", id: `${id}-help` }, (node.description ?? "").replace(/`/g, "").split("\n\n")[0]);
    const host = element("div", { class: isTick ? "field tick" : "field" }, element("label", { for: id }, label, " ", mark), control, help);
    function refresh() {
      const value = at(path);
      if (offered !== null) {
        const key = value === undefined ? "" : JSON.stringify(value);
        const all = [["", needed ? "choose" : `by default${node.default === undefined || node.default === null ? "" : ` ${textOf(node.default)}`}`], ...offered.map(([of, text]) => [JSON.stringify(of), text])];
        control.replaceChildren(...(all.some(([known]) => known === key) ? all : [...all, [key, key]]).map(([of, text]) => element("option", { value: of }, text)));
        control.value = key;
      } else if (isTick) {
        control.checked = value === true;
      } else if (document.activeElement !== control) {
        control.value = textOf(value);
      }
      mark.hidden = !needed || (value !== undefined && value !== "");
    }
    register(path, host, control, refresh);
    refresh();
    return host;
  }

  /** A part of the form with a heading, for messages about what is within a path and has no field of its own. */
  function section(title, path, ...parts) {
    const host = element("section", {}, element("h2", {}, title), ...parts);
    register(path, host, null, () => {});
    return host;
  }

  /** Shows each message beside the field that it is about, or else in the part of the form about it; gives those that have no place. */
  function showMessages(errors) {
    fields = fields.filter(({ host }) => host.isConnected);
    const texts = new Map();
    const homeless = errors.filter(({ field: name, message }) => {
      const path = name === null ? null : plainPath(name);
      const about = path === null ? [] : fields.filter((field) => path === field.path || path.startsWith(`${field.path}.`));
      const within = path === null ? [] : fields.filter((field) => field.path.startsWith(`${path}.`));
      const best = about.sort((a, b) => b.path.length - a.path.length || (b.control !== null) - (a.control !== null))[0] ?? within[0];
      if (best !== undefined) {
        texts.set(best, [...(texts.get(best) ?? []), message]);
      }
      return best === undefined;
    });
    for (const field of fields) {
      const text = (texts.get(field) ?? []).join("\n");
      field.message.textContent = text;
      field.message.hidden = text === "";
      field.control?.setAttribute("aria-invalid", String(text !== ""));
    }
    return homeless;
  }

  return {
    scene,
    at,
    put,
    field,
    section,
    register,
    showMessages,
    refresh: () => fields.forEach((field) => field.refresh()),
    /** The scene as a file, its blocks in the usual order. */
    text() {
      const place = ([key]) => (BLOCKS.includes(key) ? BLOCKS.indexOf(key) : BLOCKS.length);
      return `${JSON.stringify(Object.fromEntries(Object.entries(scene).sort((a, b) => place(a) - place(b))), null, 2)}\n`;
    },
  };
}

/** Boxes to tick of which entries a list of the scene has: those that were proposed and those that it had. A row is {entry, used, text, reason}: `reason` tells why it cannot be ticked. */
function makeRows(form, path, rows, same, details = () => []) {
  const had = form.at(path) ?? [];
  const taken = had.map((entry) => {
    const row = rows.find((candidate) => same(candidate.entry, entry));
    if (row !== undefined) {
      Object.assign(row, { entry, used: true });
    }
    return row ?? { entry, used: true, text: JSON.stringify(entry) };
  });
  const all = [...rows, ...taken.filter((row) => !rows.includes(row))];
  const host = element("div", { class: "rows" });
  const name = path.replaceAll(".", "-");

  function draw() {
    const focused = document.activeElement?.id;
    let number = -1;
    host.replaceChildren(...all.map((row, i) => {
      const id = `${name}-${i}`;
      const box = element("input", { type: "checkbox", id, checked: row.used, disabled: row.reason !== undefined, onchange: () => set(row, box.checked) });
      number += row.used ? 1 : 0;
      row.told = element("span", { class: "echo" });
      const line = element("div", { class: "row" }, element("label", { for: id }, box, " ", row.text, " ", row.told));
      if (row.reason !== undefined) {
        line.append(element("p", { class: "hint" }, row.reason));
      }
      if (row.used) {
        line.append(...details(row, `${path}.${number}`));
        form.register(`${path}.${number}`, line, null, () => {});
      }
      return line;
    }));
    document.getElementById(focused)?.focus();
  }

  function write() {
    form.put(path, all.filter((row) => row.used).map((row) => row.entry));
    draw();
  }

  /** Takes a row into the scene, or out of it. */
  function set(row, used) {
    row.used = used;
    write();
  }

  draw();
  return { host, all, set, write, add: (row) => {
    all.push(row);
    set(row, true);
  } };
}
