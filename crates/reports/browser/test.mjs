// Tests of report.html in the Chromium that the environment variable CHROMIUM names: `node test.mjs PROGRAM FOLDER [RESULTS...]`.
//
// PROGRAM is `microslip`. Scenes are written to FOLDER and run there; RESULTS are folders of further runs, on which what holds for every
// report is tested.

import assert from "node:assert/strict";
import { execFileSync, spawn, spawnSync } from "node:child_process";
import fs from "node:fs";
import path from "node:path";
import { chromium } from "playwright-core";
import { ARGUMENTS, INCOMPLETE, SCENES, STUDY, bridge } from "./scenes.mjs";

const { CHROMIUM } = process.env;
const [program, folder, ...further] = process.argv.slice(2).map((argument) => path.resolve(argument));
assert(program && folder && CHROMIUM, "CHROMIUM=chromium node test.mjs PROGRAM FOLDER [RESULTS...]");

const FLAGS = [
  "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
  "--disable-component-update", "--disable-sync", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
];
const LARGEST = 5_000_000;

/** Runs the scenes; amplitudes that do not converge are results. */
function compute() {
  fs.mkdirSync(folder, { recursive: true });
  fs.writeFileSync(path.join(folder, "bridge.msh"), bridge());
  for (const [name, scene] of Object.entries(SCENES)) {
    fs.writeFileSync(path.join(folder, `${name}.json`), JSON.stringify(scene));
    const run = spawnSync(program, ["run", `${name}.json`, "--out", name, "--overwrite", ...ARGUMENTS[name] ?? []], { cwd: folder, encoding: "utf8" });
    assert(run.status === (INCOMPLETE.has(name) ? 3 : 0), `${name}: ${run.stderr}`);
  }
}

const failures = [];
async function check(name, test) {
  try {
    await test();
    console.log(`ok ${name}`);
  } catch (error) {
    failures.push(name);
    console.log(`FAILED ${name}\n${error.stack}`);
  }
}

/** Opens a report; errors and requests are collected. */
async function open(browser, file, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 900 }, acceptDownloads: true, ...options });
  const page = await context.newPage();
  const [errors, requests] = [[], []];
  page.on("console", (message) => message.type() === "error" && errors.push(message.text()));
  page.on("pageerror", (error) => errors.push(error.stack));
  page.on("request", (request) => requests.push(request.url()));
  await page.goto(file.startsWith("http") ? file : `file://${file}`);
  await page.waitForTimeout(300);
  return { page, errors, requests: () => requests.filter((url) => !/^(file|blob):/.test(url)) };
}

const slide = (page, value) => page.locator("#live-maps input[type=range]").evaluate((slider, at) => {
  slider.value = at;
  slider.dispatchEvent(new Event("input"));
}, value);
const colours = (page) => page.locator("#live-maps path[data-element]").evaluateAll((paths) => paths.map((path) => path.getAttribute("fill")).join());
const choose = (page, section, label, value) => page.locator(`${section} label`, { hasText: label }).locator("select").selectOption({ value });

/** What holds for every report with an interface. */
async function whole(browser, results) {
  const file = path.join(results, "report.html");
  assert(fs.statSync(file).size < LARGEST, `${file} has ${fs.statSync(file).size} bytes`);
  const { page, errors, requests } = await open(browser, file);
  assert(await page.locator("html.is-live").count());
  const stops = Number(await page.locator("#live-maps input[type=range]").getAttribute("max"));
  // Every amplitude moves the faces; few let a point slip as a whole.
  await choose(page, "#live-maps", "Field", "motion");
  const before = await colours(page);
  await slide(page, stops);
  if (stops > 0) {
    assert.notEqual(await colours(page), before, "the slider does not change the map");
  }
  for (const field of ["regime", "pressure", "traction", "flux", "motion", "approach", "gap", "slip", "open"]) {
    await choose(page, "#live-maps", "Field", field);
    assert(!/NaN|undefined|Infinity/.test(await page.locator("#live-maps").innerText()), field);
  }
  await page.locator("#live-maps path[data-element]").nth(3).click({ force: true });
  assert.match(await page.locator("#live-maps .readout").first().innerText(), /Element \d+ at .*(open|%)/);
  if (stops > 0) {
    await page.locator("#live-maps .pair canvas").first().waitFor({ state: "visible" });
    assert.equal(await page.locator("#live-maps .pair canvas").count(), 2);
  }
  const drawn = await page.locator("#live-space canvas").evaluate((canvas) => new Promise((resolve) => {
    requestAnimationFrame(() => resolve(canvas.width * canvas.height > 0));
  }));
  assert(drawn);
  const narrow = await open(browser, file, { viewport: { width: 400, height: 800 } });
  const overflow = await narrow.page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
  assert(overflow <= 1, `${overflow} pixels too wide at 400`);
  assert.deepEqual([...errors, ...narrow.errors], []);
  assert.deepEqual([...requests(), ...narrow.requests()], []);
  await page.context().close();
  await narrow.page.context().close();
}

async function plain(browser) {
  const results = path.join(folder, "plain");
  const { page, errors, requests } = await open(browser, path.join(results, "report.html"));

  await check("a download is the table in the folder", async () => {
    const [download] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name: "Download backbone.csv" }).click()]);
    assert.equal(fs.readFileSync(await download.path(), "utf8"), fs.readFileSync(path.join(results, "backbone.csv"), "utf8"));
  });

  const charts = page.locator("#live-curves .chart");
  await check("points have the values of the table", async () => {
    await charts.first().focus();
    await page.keyboard.press("ArrowRight");
    const read = await page.locator("#live-curves .readout").first().innerText();
    const names = await page.locator("#live-curves .legend label").allInnerTexts();
    assert.deepEqual(names.map((name) => name.trim()).sort(), ["CQSMA", "EPMC", "RQNMA"]);
    for (let i = 0; i < names.length && !(await page.locator("#live-curves .readout").first().innerText()).startsWith("CQSMA"); i += 1) {
      await page.keyboard.press("ArrowUp");
    }
    for (let i = 0; i < 20; i += 1) {
      await page.keyboard.press("ArrowRight");
    }
    const last = await page.locator("#live-curves .readout").first().innerText();
    assert.notEqual(last, read);
    const summary = JSON.parse(fs.readFileSync(path.join(results, "summary.json"), "utf8"));
    const frequency = Number(summary.backbone.at(-1).frequency_hz.toPrecision(6));
    assert(last.includes(`frequency: ${frequency} Hz`), last);
  });
  await check("values are shown under the pointer", async () => {
    const over = charts.first().locator(".u-over");
    await over.scrollIntoViewIfNeeded();
    const box = await over.boundingBox();
    let found = "";
    for (let at = 0.02; at < 1 && !found.includes("Hz"); at += 0.02) {
      await page.mouse.move(box.x + at * box.width, box.y + 0.1 * box.height);
      found = await page.locator("#live-curves .readout").first().innerText();
    }
    assert.match(found, /frequency: [\d.]+ Hz/);
  });
  await check("the amplitude changes the label of the axis", async () => {
    for (const [value, label] of [["velocity", "velocity amplitude [m/s]"], ["acceleration", "acceleration amplitude [m/s²]"], ["modal", "modal amplitude [√kg m]"]]) {
      await choose(page, "#live-curves", "Amplitude", value);
      const name = await charts.first().getAttribute("aria-label");
      assert(name.includes(label.split(" [")[0]), name);
      // uPlot draws labels on its canvas; the reading has them as text.
      await charts.first().focus();
      await page.keyboard.press("ArrowRight");
      const read = await page.locator("#live-curves .readout").first().innerText();
      assert(read.includes(`${label.split(" [")[0]}: `) && read.includes(label.split("[")[1].replace("]", "")), read);
    }
    await choose(page, "#live-curves", "Amplitude", "displacement");
  });
  await check("a drag zooms, and the button shows all again", async () => {
    const over = charts.first().locator(".u-over");
    await over.scrollIntoViewIfNeeded();
    const box = await over.boundingBox();
    const shot = () => charts.first().locator("canvas").evaluate((canvas) => canvas.toDataURL());
    await page.mouse.move(1, 1);
    const before = await shot();
    await page.mouse.move(box.x + 0.6 * box.width, box.y + 0.05 * box.height);
    await page.mouse.down();
    await page.mouse.move(box.x + 0.9 * box.width, box.y + 0.9 * box.height, { steps: 5 });
    await page.mouse.up();
    assert.notEqual(await shot(), before);
    await page.locator("#live-curves").getByRole("button", { name: "Reset zoom" }).click();
    await page.waitForTimeout(100);
    assert.equal(await shot(), before);
  });
  await check("a measured backbone can be opened, and a wrong file says what it lacks", async () => {
    const input = page.locator("#live-curves input[type=file]");
    await input.setInputFiles({ name: "hit.csv", mimeType: "text/csv", buffer: Buffer.from("amplitude [m/s^2],frequency_hz,damping_ratio,frequency_spread_hz,damping_ratio_spread,hits\n10,169,0.002,,,1\n100,165,0.01,,,1\n") });
    await page.locator("#live-curves .legend label", { hasText: "hit.csv" }).waitFor();
    await input.setInputFiles({ name: "other.csv", mimeType: "text/csv", buffer: Buffer.from("a,b\n1,2\n") });
    await page.locator("#live-curves .told", { hasText: "other.csv: no column" }).waitFor();
  });
  await check("a click on the map shows a loop that holds the dissipated energy", async () => {
    const stops = Number(await page.locator("#live-maps input[type=range]").getAttribute("max"));
    await slide(page, stops);
    await page.locator("#live-maps path[data-element]").nth(20).click({ force: true });
    await page.locator("#live-maps .told", { hasText: "Element 21" }).waitFor();
    const area = await page.evaluate(async () => {
      // The scripts of the page are in its global scope.
      const data = JSON.parse(document.getElementById("data").textContent);
      const surface = readInterface(data.interface);
      const stop = data.modes[0].stops.at(-1);
      const loopOf = await readLoops(stop.loops);
      const flux = readFields(stop.fields).flux;
      const areas = surface.elements.map((_, i) => {
        const { jump, traction } = loopOf(i);
        let sum = 0;
        for (let k = 0; k + 1 < jump[0].length; k += 1) {
          for (let c = 0; c < 3; c += 1) {
            sum += 0.5 * (traction[c][k] + traction[c][k + 1]) * (jump[c][k + 1] - jump[c][k]);
          }
        }
        return sum;
      });
      const total = (values) => values.reduce((a, b) => a + b, 0);
      return [total(areas), total(Array.from(flux))];
    });
    // Means over elements lose what points of an element do against each other.
    assert(Math.abs(area[0] / area[1] - 1) < 0.1, String(area));
  });
  await check("arrow keys move over the map, page keys over the amplitudes", async () => {
    const map = page.locator("#live-maps svg.map");
    await map.focus();
    const read = () => page.locator("#live-maps .readout").first().innerText();
    const before = await read();
    await page.keyboard.press("ArrowRight");
    assert.notEqual(await read(), before);
    await page.keyboard.press("PageDown");
    assert.equal(await page.locator("#live-maps input[type=range]").inputValue(), String(Number(await page.locator("#live-maps input[type=range]").getAttribute("max")) - 1));
  });
  await check("the view in space turns by keys", async () => {
    const canvas = page.locator("#live-space canvas");
    await canvas.scrollIntoViewIfNeeded();
    const before = await canvas.screenshot();
    await canvas.focus();
    await page.keyboard.press("ArrowLeft");
    await page.keyboard.press("ArrowLeft");
    await page.waitForTimeout(200);
    assert(!before.equals(await canvas.screenshot()));
  });
  await check("the tabulator reaches everything", async () => {
    await page.evaluate(() => {
      document.activeElement.blur();
      window.scrollTo(0, 0);
    });
    const wanted = await page.evaluate(() => {
      const all = [...document.querySelectorAll("button, select, input, summary, [tabindex='0']")].filter((found) => found.checkVisibility());
      all.forEach((found, i) => found.setAttribute("data-wanted", i));
      return all.length;
    });
    const reached = new Set();
    for (let i = 0; i < wanted + 5; i += 1) {
      await page.keyboard.press("Tab");
      reached.add(await page.evaluate(() => document.activeElement.getAttribute("data-wanted")));
    }
    reached.delete(null);
    assert.equal(reached.size, wanted);
    const unnamed = await page.evaluate(() => [...document.querySelectorAll(".live input, .live select, .live button, .live [tabindex='0']")]
      .filter((found) => !(found.getAttribute("aria-label") || found.closest("label")?.textContent.trim() || found.textContent.trim())).length);
    assert.equal(unnamed, 0);
  });
  await check("paper has the pictures and no controls", async () => {
    await page.emulateMedia({ media: "print" });
    assert.equal(await page.locator(".static svg").first().isVisible(), true);
    assert.equal(await page.locator("#live-maps").isVisible(), false);
    await page.emulateMedia({ media: "screen" });
    assert.equal(await page.locator(".static svg").first().isVisible(), false);
  });
  await check("nothing was asked for and nothing went wrong", () => {
    assert.deepEqual(errors, []);
    assert.deepEqual(requests(), []);
  });
  await page.context().close();

  await check("without scripts the pictures are there", async () => {
    const plainPage = await open(browser, path.join(results, "report.html"), { javaScriptEnabled: false });
    assert.equal(await plainPage.page.locator(".static svg").first().isVisible(), true);
    assert.equal(await plainPage.page.locator("table").first().isVisible(), true);
    assert.equal(await plainPage.page.locator(".live").first().isVisible(), false);
    await plainPage.page.context().close();
  });
}

compute();
const browser = await chromium.launch({ executablePath: CHROMIUM, args: FLAGS });
await plain(browser);
for (const name of Object.keys(SCENES)) {
  await check(`whole: ${name}`, () => whole(browser, path.join(folder, name)));
}
for (const results of further) {
  await check(`whole: ${results}`, () => whole(browser, results));
}
await check("a name does not break out", async () => {
  const { page, errors } = await open(browser, path.join(folder, "hostile/report.html"));
  assert.equal(await page.title(), SCENES.hostile.name);
  assert.equal(await page.locator("img").count(), 0);
  assert.deepEqual(errors, []);
});
await check("modes and interfaces can be chosen", async () => {
  const { page, errors } = await open(browser, path.join(folder, "several/report.html"));
  const all = await page.locator("#live-maps path[data-element]").count();
  assert.equal(all, 9);
  await choose(page, "#live-maps", "Interface", "1");
  assert.equal(await page.locator("#live-maps path[data-element]").first().getAttribute("data-element"), "9");
  // Interfaces lie side by side in one plane; places are those in the model.
  await page.locator("#live-maps path[data-element]").last().click({ force: true });
  assert.match(await page.locator("#live-maps .readout").first().innerText(), /Element 18 at x 115.00 mm, y 25.00 mm/);
  await choose(page, "#live-curves", "Mode", "1");
  assert.equal(await page.locator("#live-maps label", { hasText: "Mode" }).locator("select").inputValue(), "1");
  assert.equal(await page.locator("#live-table-1 button").innerText(), "Download mode-2-backbone.csv");
  assert.deepEqual(errors, []);
});
await check("without WebGL a sentence stands where the view was", async () => {
  const without = await chromium.launch({ executablePath: CHROMIUM, args: [...FLAGS.slice(0, -3), "--disable-3d-apis"] });
  const { page, errors } = await open(without, path.join(folder, "single/report.html"));
  assert.match(await page.locator("#live-space").innerText(), /no WebGL/);
  assert.deepEqual(errors, []);
  await without.close();
});
await check("mode shapes can be chosen", async () => {
  execFileSync(program, ["model", "plain.json", "--modes", "2", "--out", "modes", "--overwrite"], { cwd: folder, stdio: "ignore" });
  const file = path.join(folder, "modes/report.html");
  const { page, errors, requests } = await open(browser, file);
  const canvas = page.locator("#live-shapes canvas");
  const before = await canvas.screenshot();
  await choose(page, "#live-shapes", "Mode", "1");
  await page.waitForTimeout(300);
  assert(!before.equals(await canvas.screenshot()));
  assert(fs.statSync(file).size < LARGEST);
  assert.deepEqual([errors, requests()], [[], []]);
});
await check("cases of a study can be looked at one by one", async () => {
  fs.writeFileSync(path.join(folder, "plan.json"), JSON.stringify(STUDY));
  execFileSync(program, ["study", "plan.json", "--out", "study", "--overwrite"], { cwd: folder, stdio: "ignore" });
  const file = path.join(folder, "study/report.html");
  assert(fs.statSync(file).size < LARGEST);
  const began = Date.now();
  const { page, errors, requests } = await open(browser, file);
  assert(Date.now() - began < 1300, "it takes more than a second to load");
  const told = page.locator("#live-cases .told");
  const slider = page.locator("#live-cases input[type=range]");
  assert.equal(await slider.getAttribute("max"), "5");
  assert.match(await told.innerText(), /Case 1 .*mu: 0.1.*gap: flat/);
  const charts = page.locator("#live-cases canvas");
  const before = await charts.first().screenshot();
  await slider.focus();
  await page.keyboard.press("End");
  assert.match(await told.innerText(), /Case 6 .*mu: 0.3.*gap: measured/);
  assert(!before.equals(await charts.first().screenshot()), "the slider changes no curve");
  const colours = await charts.first().screenshot();
  await choose(page, "#live-cases", "Colour by", "1");
  assert(!colours.equals(await charts.first().screenshot()), "the parameter changes no colour");
  assert.match(await page.locator("#live-cases .legend").innerText(), /flat\s+measured/);
  // A click on a curve chooses its case: on the point of the case that is shown the readout names it.
  await page.locator("#live-cases .chart").first().focus();
  await page.keyboard.press("ArrowRight");
  assert.match(await page.locator("#live-cases .readout").first().innerText(), /case \d+ .*Hz/);
  assert.equal(await page.getByText("relative to its mean").count(), 2);
  assert.equal(await page.locator("figure svg").count(), 2, "few cases need no parallel coordinates");
  const narrow = await open(browser, file, { viewport: { width: 400, height: 800 } });
  const overflow = await narrow.page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
  assert(overflow <= 1, `${overflow} pixels too wide at 400`);
  const still = await open(browser, file, { javaScriptEnabled: false });
  assert.equal(await still.page.locator("figure svg").first().isVisible(), true);
  assert.equal(await still.page.locator("#live-cases").isVisible(), false);
  assert.deepEqual([...errors, ...narrow.errors], []);
  assert.deepEqual(requests(), []);
});
await check("bands of uncertain inputs are drawn about the curve", async () => {
  const { page, errors } = await open(browser, path.join(folder, "uncertain/report.html"));
  const bands = await page.evaluate(() => JSON.parse(document.getElementById("data").textContent).modes[0].bands);
  assert(bands.length >= 3 && bands.every((band) => band.frequency_hz[0] < band.frequency_hz[2]), JSON.stringify(bands));
  // Shades of the colour of the curve that no line has.
  const shaded = await page.locator("#live-curves canvas").first().evaluate((canvas) => {
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    let count = 0;
    for (let i = 0; i < data.length; i += 4) {
      count += data[i + 3] > 40 && data[i + 3] < 60 ? 1 : 0;
    }
    return count;
  });
  assert(shaded > 200, `${shaded} pixels are shaded`);
  assert.deepEqual(errors, []);
});
await check("runs are shown beside each other", async () => {
  const server = spawn(program, ["view", "plain", "several", "--no-open"], { cwd: folder });
  try {
    const line = await new Promise((resolve) => {
      server.stdout.once("data", (text) => resolve(String(text)));
    });
    const address = line.match(/http:\/\/127\.0\.0\.1:\d+\//)[0];
    const { page, errors, requests } = await open(browser, address);
    const names = await page.locator("#live-curves .legend label").allInnerTexts();
    assert.deepEqual(names.map((name) => name.trim()).sort(), ["plain", "plain, EPMC", "plain, RQNMA", "several"]);
    await choose(page, "#live-curves", "Mode", "1");
    assert.deepEqual((await page.locator("#live-curves .legend label").allInnerTexts()).map((name) => name.trim()), ["several"]);
    await page.getByRole("link", { name: "several" }).click();
    await page.locator("#live-maps svg.map").waitFor();
    assert.deepEqual(errors, []);
    assert(requests().every((url) => url.startsWith(address)), requests().join());
  } finally {
    server.kill();
  }
});
await browser.close();
console.log(failures.length === 0 ? "all passed" : `${failures.length} failed: ${failures.join("; ")}`);
process.exitCode = failures.length === 0 ? 0 : 1;
