// Tables of comma-separated values.

/** Rows of cells of a text; cells may be quoted. */
function parseTable(text) {
  const rows = [];
  let row = [];
  let cell = "";
  let quoted = false;
  for (let i = 0; i < text.length; i += 1) {
    const c = text[i];
    if (quoted) {
      if (c !== '"') {
        cell += c;
      } else if (text[i + 1] === '"') {
        cell += '"';
        i += 1;
      } else {
        quoted = false;
      }
    } else if (c === '"') {
      quoted = true;
    } else if (c === "," || c === "\n") {
      row.push(cell.endsWith("\r") ? cell.slice(0, -1) : cell);
      cell = "";
      if (c === "\n") {
        rows.push(row);
        row = [];
      }
    } else {
      cell += c;
    }
  }
  if (cell !== "" || row.length > 0) {
    rows.push([...row, cell]);
  }
  return rows.filter((cells) => cells.some((text) => text !== ""));
}

/** Columns of a table by their headings: arrays of numbers, null where a cell is empty or has none. */
function columnsOf(text) {
  const [headings = [], ...rows] = parseTable(text);
  const number = (cell) => (cell === undefined || cell.trim() === "" || !Number.isFinite(Number(cell)) ? null : Number(cell));
  return new Map(headings.map((heading, i) => [heading.trim(), rows.map((cells) => number(cells[i]))]));
}

/** Fills in the amplitudes that follow from those that are given, in a harmonic motion. */
function withAmplitudes(curve) {
  const n = curve.frequency.length;
  const none = new Array(n).fill(null);
  const from = (values, factor) => values.map((value, i) => (value === null || curve.frequency[i] === null ? null : value * factor(TURN * curve.frequency[i])));
  let { displacement, velocity, acceleration } = curve;
  displacement ??= velocity ? from(velocity, (w) => 1 / w) : acceleration ? from(acceleration, (w) => 1 / (w * w)) : none;
  velocity ??= from(displacement, (w) => w);
  acceleration ??= from(displacement, (w) => w * w);
  return { modal: none, damping: none, ...curve, displacement, velocity, acceleration };
}

/** The backbone in a table as `run` or `identify` writes it; an error says what is missing. */
function backboneOf(text) {
  const columns = columnsOf(text);
  const first = (...names) => names.map((name) => columns.get(name)).find((values) => values !== undefined);
  const frequency = first("frequency [Hz]", "frequency_hz");
  if (frequency === undefined) {
    throw new Error("no column \"frequency [Hz]\" or \"frequency_hz\"");
  }
  const curve = {
    frequency,
    damping: first("damping_ratio [-]", "damping_ratio"),
    displacement: first("response_displacement [m]", "amplitude [m]"),
    velocity: first("amplitude [m/s]"),
    acceleration: first("response_acceleration [m/s^2]", "amplitude [m/s^2]", "amplitude [m/s\u00b2]"),
    modal: first("modal_amplitude [sqrt(kg) m]"),
  };
  if (!curve.displacement && !curve.velocity && !curve.acceleration) {
    throw new Error("no column \"response_displacement [m]\", \"amplitude [m]\", \"amplitude [m/s]\" or \"amplitude [m/s^2]\"");
  }
  return withAmplitudes(curve);
}

/** The button that hands out the table of a backbone. */
function downloadButton(file, text) {
  return button(`Download ${file}`, () => download(file, text, "text/csv"), { class: "download" });
}
