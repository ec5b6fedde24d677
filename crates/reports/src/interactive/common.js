// Elements, numbers and arrays.

const TURN = 2 * Math.PI;

/** An element with attributes and children; attributes that begin with `on` are listeners. */
function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) {
      made.addEventListener(key.slice(2), value);
    } else if (value === true) {
      made.setAttribute(key, "");
    } else if (value !== false && value !== null && value !== undefined) {
      made.setAttribute(key, value);
    }
  }
  made.append(...children);
  return made;
}

/** An element of a picture. */
function svgElement(name, attributes = {}, ...children) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) {
    made.setAttribute(key, value);
  }
  made.append(...children);
  return made;
}

/** A labelled choice among `options`, pairs of value and text; `chosen` is told the value. */
function choice(label, options, value, chosen) {
  const select = element("select", { onchange: () => chosen(select.value) });
  for (const [key, text] of options) {
    select.append(element("option", { value: key, selected: String(key) === String(value) }, text));
  }
  return element("label", { class: "control" }, `${label} `, select);
}

/** A labelled box to tick. */
function tick(label, value, chosen) {
  const box = element("input", { type: "checkbox", checked: value, onchange: () => chosen(box.checked) });
  return element("label", { class: "control" }, box, ` ${label}`);
}

/** A button. */
function button(text, pressed, attributes = {}) {
  return element("button", { type: "button", onclick: pressed, ...attributes }, text);
}

/** Bytes of base64 text. */
function bytesOf(text) {
  const raw = atob(text);
  const bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i += 1) {
    bytes[i] = raw.charCodeAt(i);
  }
  return bytes;
}

/** An array of little-endian numbers, as all processors with a browser have them. */
function arrayOf(Type, text) {
  return new Type(bytesOf(text).buffer);
}

const RAISED = { "-": "\u207b", 0: "\u2070", 1: "\u00b9", 2: "\u00b2", 3: "\u00b3", 4: "\u2074", 5: "\u2075", 6: "\u2076", 7: "\u2077", 8: "\u2078", 9: "\u2079" };

/** A whole power of ten. */
function powerOfTen(exponent) {
  return `10${Array.from(String(exponent), (digit) => RAISED[digit]).join("")}`;
}

/** A number for reading, with `digits` significant ones. */
function readable(value, digits = 4) {
  if (value === null || value === undefined || !Number.isFinite(value)) {
    return "\u2013";
  }
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-3 || size >= 1e5)) {
    const [mantissa, exponent] = value.toExponential(digits - 1).split("e");
    return `${mantissa}\u00b7${powerOfTen(Number(exponent))}`;
  }
  return String(Number(value.toPrecision(digits)));
}

const PREFIXES = [[1e9, "G"], [1e6, "M"], [1e3, "k"], [1, ""], [1e-3, "m"], [1e-6, "\u00b5"], [1e-9, "n"]];

/** Factor and unit in which values up to `largest` are read best; shares stay as they are. */
function scaleOf(largest, unit) {
  if (unit === "" || unit === "-" || !(largest > 0)) {
    return { factor: 1, unit };
  }
  const [size, prefix] = PREFIXES.find(([size]) => largest >= 0.9995 * size) ?? PREFIXES.at(-1);
  return { factor: 1 / size, unit: prefix + unit };
}

const VIRIDIS = [
  [68, 1, 84], [71, 45, 123], [59, 82, 139], [44, 114, 142], [33, 145, 140], [40, 174, 128], [94, 201, 98], [173, 220, 48], [253, 231, 37],
];

/** Red, green and blue of the viridis map at `part` from 0 to 1. */
function viridis(part) {
  const position = Math.min(Math.max(part, 0), 1) * (VIRIDIS.length - 1);
  const low = Math.min(Math.floor(position), VIRIDIS.length - 2);
  return VIRIDIS[low].map((c, i) => Math.round(c + (position - low) * (VIRIDIS[low + 1][i] - c)));
}

/** A colour as style sheets have it. */
function css(rgb) {
  return `rgb(${rgb.join(",")})`;
}

/** Hands text to the reader as a file. */
function download(name, text, type) {
  const address = URL.createObjectURL(new Blob([text], { type }));
  const link = element("a", { href: address, download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(address), 1000);
}

/** What is chosen on a page; listeners are told what changed. */
function makeState(values) {
  const listeners = [];
  return {
    values,
    listen: (listener) => listeners.push(listener),
    set(changes) {
      const changed = Object.keys(changes).filter((key) => values[key] !== changes[key]);
      Object.assign(values, changes);
      if (changed.length > 0) {
        listeners.forEach((listener) => listener(changed));
      }
    },
  };
}
