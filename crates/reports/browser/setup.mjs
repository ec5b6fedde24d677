// Tests of the page of `setup` in the Chromium that the environment variable CHROMIUM names: `node setup.mjs PROGRAM FOLDER`.
//
// A lap joint is set up from its mesh to a finished backbone, once with the mouse and once with the keyboard alone. Pictures of the page are
// written to FOLDER.

import assert from "node:assert/strict";
import { execFileSync, spawn } from "node:child_process";
import fs from "node:fs";
import path from "node:path";
import { chromium } from "playwright-core";
import { lap } from "./scenes.mjs";

const { CHROMIUM } = process.env;
const [program, folder] = process.argv.slice(2).map((argument) => path.resolve(argument));
assert(program && folder && CHROMIUM, "CHROMIUM=chromium node setup.mjs PROGRAM FOLDER");

const FLAGS = [
  "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
  "--disable-component-update", "--disable-sync", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
];

/** Longest time from the mesh to its backbone (s). */
const GOAL = 120;

/** Starts the program on a file, and gives it with the address that it prints. */
async function serve(file) {
  const server = spawn(program, ["setup", file, "--no-open"], { cwd: folder, env: { ...process.env, XDG_CACHE_HOME: path.join(folder, "caches") } });
  const line = await new Promise((resolve, reject) => {
    server.stdout.once("data", (text) => resolve(String(text)));
    server.once("exit", (code) => reject(new Error(`the program ended with ${code}`)));
  });
  assert.match(line, /^http:\/\/127\.0\.0\.1:\d+\/[0-9a-f]{32}\/\n$/);
  return { server, address: line.trim() };
}

/** Opens a page; errors and requests are collected. */
async function open(browser, address, width) {
  const context = await browser.newContext({ viewport: { width, height: 900 } });
  const page = await context.newPage();
  const [errors, requests] = [[], []];
  context.on("console", (message) => message.type() === "error" && errors.push(message.text()));
  page.on("pageerror", (error) => errors.push(error.stack));
  context.on("request", (request) => requests.push(request.url()));
  await page.goto(address);
  await page.locator("canvas.space").waitFor();
  const end = async () => {
    const overflow = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
    assert(overflow <= 1, `${overflow} pixels too wide at ${width}`);
    assert.deepEqual(errors, []);
    assert(requests.every((url) => url.startsWith(address) || url.startsWith("blob:")), requests.join());
    await context.close();
  };
  return { page, end };
}

const at = (page, name) => page.locator(`[data-path="${name}"]`);
const points = (page) => page.locator("[data-points]").getAttribute("data-points").then(Number);
const wrong = (page, name) => at(page, name).locator(":scope > .wrong");
const read = (file) => JSON.parse(fs.readFileSync(path.join(folder, file), "utf8"));

/** Clicks here and there in the picture until what is picked has a text. */
async function clickFor(page, wanted) {
  const canvas = page.locator("canvas.space");
  await canvas.scrollIntoViewIfNeeded();
  for (let i = 0; i < 1000; i += 1) {
    const box = await canvas.boundingBox();
    // Places that spread evenly.
    const [x, y] = [0.1 + 0.8 * ((0.754877 * i) % 1), 0.1 + 0.8 * ((0.569841 * i) % 1)];
    await page.mouse.click(box.x + x * box.width, box.y + y * box.height);
    if (wanted.test(await page.locator(".view .told").innerText())) {
      return;
    }
  }
  await page.screenshot({ path: path.join(folder, "failed.png") });
  assert.fail(`nothing in the picture is ${wanted}`);
}

/** What a mesh cannot tell. */
const VALUES = [
  ["interfaces.mu", "0.2"], ["bolts.load", "12.7 kN"], ["model.material.youngs_modulus", "192.85 GPa"],
  ["model.material.poisson_ratio", "0.29"], ["model.material.density", "7857.8 kg/m^3"],
];

async function byMouse(browser) {
  const { server, address } = await serve("mouse/lap.msh");
  try {
    const begin = performance.now();
    const { page, end } = await open(browser, address, 1280);
    const run = page.getByRole("button", { name: "Run", exact: true });
    await wrong(page, "units").waitFor();
    assert(await run.isDisabled());
    assert.match(await wrong(page, "interfaces.surface").innerText(), /interfaces\.surface is missing/);
    assert.equal(await page.locator(".needed:visible").count(), 8);
    await page.screenshot({ path: path.join(folder, "begin-1280.png") });

    await at(page, "units").locator("select").selectOption({ label: "mm" });
    assert.equal(await at(page, "structure.mesh.bolts.0.size").locator("input").inputValue(), "M8");
    for (const [name, value] of VALUES) {
      await at(page, name).locator("input").fill(value);
    }
    await page.getByLabel("The faces are known by").selectOption("benchmark");
    await at(page, "interfaces.surface.benchmark").locator("select").selectOption({ label: "brake-reuss-beam" });
    await page.getByText("The scene is complete.").waitFor();

    // What the program says is beside the field, in its words.
    await at(page, "model.material.poisson_ratio").locator("input").fill("0.7");
    await wrong(page, "model.material.poisson_ratio").waitFor();
    assert.match(await wrong(page, "model.material.poisson_ratio").innerText(), /poisson_ratio = 0\.7 is not admissible; it must be above -1 and below 0\.5/);
    assert.equal(await at(page, "model.material.poisson_ratio").locator("input").getAttribute("aria-invalid"), "true");
    assert(await run.isDisabled());
    await at(page, "model.material.poisson_ratio").locator("input").fill("0.29");
    await at(page, "bolts.load").locator("input").fill("12 stone");
    await wrong(page, "bolts.load").waitFor();
    await at(page, "bolts.load").locator("input").fill("12.7 kN");
    await page.getByText("The scene is complete.").waitFor();

    // Bolts, held faces and the response by clicks in the picture.
    await clickFor(page, /^Bolt: hole of 9/);
    await page.getByRole("button", { name: "Leave the bolt out" }).click();
    assert.equal(await page.locator("#structure-mesh-bolts-0:checked, #structure-mesh-bolts-1:checked").count(), 1);
    await page.getByRole("button", { name: "Take the bolt" }).click();
    assert.equal(await page.locator("#structure-mesh-bolts-0:checked, #structure-mesh-bolts-1:checked").count(), 2);
    await clickFor(page, /It is part of upper on lower/);
    await page.getByRole("button", { name: "No interface: upper on lower" }).click();
    await wrong(page, "structure.mesh.interfaces").waitFor();
    await page.getByRole("button", { name: "Interface: upper on lower", exact: true }).click();
    for (const turn of ["Turn left", "Turn left", "Turn left", "Turn left", "Farther", "Farther"]) {
      await page.getByRole("button", { name: turn }).click();
    }
    await clickFor(page, /lower: plane, normal \(-1, 0, 0\)/);
    await page.getByRole("button", { name: "Hold end <i>", exact: true }).click();
    await page.screenshot({ path: path.join(folder, "held-1280.png") });
    await page.getByRole("button", { name: "Do not hold end <i>" }).click();
    // Names stay text.
    assert.equal(await page.locator("main i").count(), 0);
    await page.getByRole("button", { name: "Whole model" }).click();
    await clickFor(page, /lower: plane, normal \(0, -1, 0\)/);
    // Without a name in the mesh it is held by a position on it.
    await page.getByRole("button", { name: "Hold this face" }).click();
    await page.getByText("The scene is complete.").waitFor();
    await page.getByRole("button", { name: /^Do not hold the face at/ }).click();
    await page.getByText("The scene is complete.").waitFor();
    await page.getByRole("button", { name: "Force here" }).click();
    assert.match(await at(page, "analyses.forced.node").locator("input").inputValue(), /^\d+$/);
    await wrong(page, "analyses.forced.levels").waitFor();
    await page.getByLabel("also the response to a harmonic force").uncheck();
    await clickFor(page, /upper: plane, normal \(0, 0, 1\)/);
    await page.getByRole("button", { name: "Response here" }).click();
    const response = at(page, "structure.mesh.response.nearest").locator("input");
    assert.match(await response.inputValue(), /, 8$/);
    assert.equal(await at(page, "structure.mesh.response.direction").locator("input").inputValue(), "0, 0, 1");
    // The corner moves most.
    await response.fill("200, 20, 8");
    await page.getByText("The scene is complete.").waitFor();
    assert.match(await page.locator("[aria-label='Bodies that are shown']").innerText(), /upper .* 0\.49\d+ kg/);
    assert.match(await page.locator("label[for='structure-mesh-interfaces-0']").innerText(), /30\d\d\.?\d* mm²/);
    assert.match(await page.locator("label[for='structure-mesh-bolts-0']").innerText(), /head covered to \d+ %, nut covered to \d+ %/);
    await page.screenshot({ path: path.join(folder, "complete-1280.png") });

    // The backbone grows; a run can be stopped, and goes on where it was.
    await run.click();
    await page.waitForFunction(() => Number(document.querySelector("[data-points]")?.dataset.points) >= 2);
    // At once: the loops take few seconds.
    await page.getByRole("button", { name: "Stop" }).click();
    await page.getByText("Stopped.").waitFor();
    assert(await points(page) >= 2);
    await page.screenshot({ path: path.join(folder, "stopped-1280.png") });
    await page.getByRole("button", { name: "Run again" }).click();
    await page.getByText("Finished.").waitFor({ timeout: 1000 * GOAL });
    const seconds = (performance.now() - begin) / 1000;
    assert.equal(await points(page), 8);
    assert.match(await page.locator("pre.answer").innerText(), /^mode 1: 42\d\.\d\d Hz at small amplitude/);
    await page.screenshot({ path: path.join(folder, "finished-1280.png"), fullPage: true });
    const [report] = await Promise.all([page.context().waitForEvent("page"), page.getByRole("link", { name: "Open the report" }).click()]);
    await report.locator("#live-maps svg.map").waitFor();
    // A page that is loaded again is as it was.
    await page.reload();
    await page.getByText("Finished.").waitFor();
    assert.equal(await points(page), 8);
    assert.equal(await at(page, "bolts.load").locator("input").inputValue(), "12.7 kN");
    await page.getByText("The scene is complete.").waitFor();
    await end();
    assert(seconds < GOAL, `${seconds.toFixed(1)} s from the mesh to the backbone`);
    console.log(`ok from the mesh to the backbone with the mouse, stopped once: ${seconds.toFixed(1)} s`);
  } finally {
    server.kill();
  }
  // What was saved is a scene of its own, with the same results.
  execFileSync(program, ["run", "mouse/scene.json", "--out", "again", "--no-cache"], { cwd: folder, stdio: "ignore" });
  assert.deepEqual(read("again/summary.json").backbone, read("mouse/results/scene/summary.json").backbone);
  console.log("ok the saved scene has the same backbone when it is run alone");
}

async function byKeyboard(browser) {
  const { server, address } = await serve("keyboard/lap.msh");
  try {
    const begin = performance.now();
    const { page, end } = await open(browser, address, 400);
    const key = (name) => page.keyboard.press(name);
    /** Presses Tab until the control that a selector names has the focus, and that is seen. */
    const reach = async (selector) => {
      for (let i = 0; i < 200; i += 1) {
        await key("Tab");
        const found = await page.evaluate((wanted) => document.activeElement.matches(wanted) && getComputedStyle(document.activeElement).outlineStyle !== "none", selector);
        if (found) {
          return;
        }
      }
      assert.fail(`the tabulator does not reach ${selector}`);
    };
    const button = (text) => page.evaluate((wanted) => {
      document.querySelectorAll("[data-wanted]").forEach((old) => old.removeAttribute("data-wanted"));
      [...document.querySelectorAll("button")].find((one) => one.textContent === wanted).setAttribute("data-wanted", "");
    }, text).then(() => reach("[data-wanted]"));

    // The response at the middle of the upper face, from the list of faces.
    await reach(".view select");
    await page.keyboard.type("upper: plane, normal (0, 0, 1)");
    await button("Response here");
    await key("Enter");
    await reach("[data-path='units'] select");
    await page.keyboard.type("mm");
    await reach("[data-path='interfaces.mu'] input");
    await page.keyboard.type("0.2");
    await reach("[data-path='interfaces.surface'] select");
    await page.keyboard.type("measured");
    await reach("[data-path='interfaces.surface.benchmark'] select");
    await page.keyboard.type("brake");
    await reach("#structure-mesh-bolts-0");
    await key("Space");
    await key("Space");
    for (const [name, value] of VALUES.slice(1)) {
      await reach(`[data-path='${name}'] input`);
      await page.keyboard.type(value);
    }
    await reach("#structure-mesh-supports-0");
    await key("Space");
    await reach("[data-path='analyses.backbone.amplitudes'] input");
    await key("Control+A");
    await page.keyboard.type("4");
    await page.getByText("The scene is complete.").waitFor();
    await page.screenshot({ path: path.join(folder, "complete-400.png"), fullPage: true });
    await button("Save");
    await key("Enter");
    await page.getByText("scene.json is there already").waitFor();
    assert.equal(fs.readFileSync(path.join(folder, "keyboard/scene.json"), "utf8"), "somebody else's");
    // The question has the focus.
    await key("Enter");
    await page.getByText("Saved as scene.json.").waitFor();
    await button("Run");
    await key("Enter");
    await page.getByText("Finished.").waitFor({ timeout: 1000 * GOAL });
    const seconds = (performance.now() - begin) / 1000;
    assert.equal(await points(page), 4);
    await page.screenshot({ path: path.join(folder, "finished-400.png"), fullPage: true });
    const unnamed = await page.evaluate(() => [...document.querySelectorAll("input, select, button, [tabindex='0'], progress")]
      .filter((found) => !(found.getAttribute("aria-label") || found.closest("label")?.textContent.trim() || found.textContent.trim() || document.querySelector(`label[for="${found.id}"]`)))
      .map((found) => found.outerHTML));
    assert.deepEqual(unnamed, []);
    await end();
    const scene = read("keyboard/scene.json");
    assert.deepEqual(scene.structure.mesh.supports, [{ surface: "end <i>" }]);
    assert.deepEqual(scene.structure.mesh.response.direction, [0, 0, 1]);
    assert.equal(read("keyboard/results/scene/summary.json").backbone.length, 4);
    assert(seconds < GOAL, `${seconds.toFixed(1)} s from the mesh to the backbone`);
    console.log(`ok from the mesh to the backbone by the keyboard at 400 pixels: ${seconds.toFixed(1)} s`);
  } finally {
    server.kill();
  }
}

/** A scene that is there already is gone on with, and what the page does not know of it stays. */
async function again(browser) {
  const scene = { ...read("mouse/scene.json"), background_damping: 0.001 };
  fs.writeFileSync(path.join(folder, "mouse/other.json"), JSON.stringify(scene));
  const { server, address } = await serve("mouse/other.json");
  try {
    const { page, end } = await open(browser, address, 1280);
    await page.getByText("The scene is complete.").waitFor();
    assert.equal(await at(page, "bolts.load").locator("input").inputValue(), "12.7 kN");
    await at(page, "bolts.load").locator("input").fill("10 kN");
    await page.getByText("The scene is complete.").waitFor();
    await page.getByRole("button", { name: "Save" }).click();
    await page.getByRole("button", { name: "Replace other.json" }).click();
    await page.getByText("Saved as other.json.").waitFor();
    assert.deepEqual(read("mouse/other.json"), { ...scene, bolts: { load: "10 kN" } });
    await end();
    console.log("ok a scene that is there is gone on with");
  } finally {
    server.kill();
  }
}

fs.rmSync(folder, { recursive: true, force: true });
for (const name of ["mouse", "keyboard"]) {
  fs.mkdirSync(path.join(folder, name), { recursive: true });
  fs.writeFileSync(path.join(folder, name, "lap.msh"), lap());
}
fs.writeFileSync(path.join(folder, "keyboard/scene.json"), "somebody else's");
const browser = await chromium.launch({ executablePath: CHROMIUM, args: FLAGS });
try {
  await byMouse(browser);
  await byKeyboard(browser);
  await again(browser);
} finally {
  await browser.close();
}
console.log("all passed");
