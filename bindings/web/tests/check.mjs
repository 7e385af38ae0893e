// Checks the package and the page in Chromium: node check.mjs BUILD PHOTO2NATIVE EXAMPLES [WORD...]
// Runs the checks whose names contain one of the words; default: all.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { copyFileSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { basename, join, resolve } from "node:path";
import { crc32, deflateSync } from "node:zlib";
import { serve } from "../serve.mjs";

const [build, photo2native, examples, ...words] = process.argv.slice(2);
const { chromium } = createRequire(resolve(build, "npm/package.json"))("playwright-core");
const calibration = resolve(examples, "../../calibration/portrait-sample.json");
const sample = resolve(examples, "sample.jpg");
const made = resolve(build, "check");
mkdirSync(made, { recursive: true });
copyFileSync(calibration, join(made, "visual.json"));
copyFileSync(sample, join(made, "sample.jpg"));
const server = await serve(resolve(build), 0);
const site = `http://localhost:${server.address().port}`;
const launch = (...args) => chromium.launch({ executablePath: "/usr/bin/chromium", args });
const browser = await launch();

// A grey PNG of 16 bits.
function greyPng(width, height, values) {
  const rows = Buffer.alloc(height * (2 * width + 1));
  for (let y = 0; y < height; ++y)
    for (let x = 0; x < width; ++x) rows.writeUInt16BE(values(x, y), y * (2 * width + 1) + 1 + 2 * x);
  const chunk = (type, contents) => {
    const body = Buffer.concat([Buffer.from(type), contents]);
    const whole = Buffer.alloc(body.length + 8);
    whole.writeUInt32BE(contents.length);
    body.copy(whole, 4);
    whole.writeUInt32BE(crc32(body), body.length + 4);
    return whole;
  };
  const head = Buffer.alloc(13);
  head.writeUInt32BE(width);
  head.writeUInt32BE(height, 4);
  head[8] = 16;
  const signature = Buffer.from("\x89PNG\r\n\x1a\n", "latin1");
  return Buffer.concat([signature, chunk("IHDR", head), chunk("IDAT", deflateSync(rows)), chunk("IEND", Buffer.alloc(0))]);
}

// A JPEG with a segment after its start.
function withSegment(jpeg, marker, body) {
  const head = Buffer.from([0xff, marker, 0, 0]);
  head.writeUInt16BE(body.length + 2, 2);
  return Buffer.concat([jpeg.subarray(0, 2), head, body, jpeg.subarray(2)]);
}

// Numbers of 16 and 32 bits, as [value, bytes].
const numbers = (...values) =>
  Buffer.concat(values.map(([value, bytes]) => Buffer.from(value.toString(16).padStart(2 * bytes, "0"), "hex")));

// EXIF with the orientation.
const exif = (orientation) =>
  Buffer.concat([
    Buffer.from("Exif\0\0MM\0*"),
    numbers([8, 4], [1, 2], [0x112, 2], [3, 2], [1, 4], [orientation, 2], [0, 2], [0, 4]),
  ]);

// XMP with depth in metres.
const gDepth = (png) =>
  Buffer.from(
    `http://ns.adobe.com/xap/1.0/\0<x:xmpmeta xmlns:x='adobe:ns:meta/'><rdf:RDF
    xmlns:rdf='http://www.w3.org/1999/02/22-rdf-syntax-ns#'><rdf:Description
    xmlns:GDepth='http://ns.google.com/photos/1.0/depthmap/' GDepth:Format='RangeLinear' GDepth:Near='5.5e-1'
    GDepth:Far='10.25' GDepth:Mime='image/png' GDepth:Data='${png.toString("base64")}'/></rdf:RDF></x:xmpmeta>`,
  );

// A file of a 3D camera: the left picture, an index, the right picture (CIPA DC-007).
function mpo(left, right) {
  const index = (offset) =>
    Buffer.concat([
      Buffer.from("MPF\0MM\0*"),
      numbers([8, 4], [1, 2], [0xb002, 2], [7, 2], [32, 4], [26, 4], [0, 4]),
      numbers([0x020002, 4], [0, 4], [0, 4], [0, 4], [0x020002, 4], [right.length, 4], [offset, 4], [0, 4]),
    ]);
  const first = withSegment(left, 0xe2, index(0)).length;
  return Buffer.concat([withSegment(left, 0xe2, index(first - 10)), right]); // from the byte order mark on
}

// A network of one layer, as ONNX: its depth is the red of the photo. A weight that is not used makes it large.
function redNetwork() {
  const number = (value) => {
    const bytes = [];
    for (; value > 127; value = Math.floor(value / 128)) bytes.push((value % 128) | 128);
    return Buffer.from([...bytes, value]);
  };
  const field = (id, value) => {
    if (typeof value === "number") return Buffer.concat([number(8 * id), number(value)]);
    const bytes = Buffer.from(value);
    return Buffer.concat([number(8 * id + 2), number(bytes.length), bytes]);
  };
  const message = (...fields) => Buffer.concat(fields.map(([id, value]) => field(id, value)));
  const weights = (name, dims, values) =>
    message(...dims.map((dim) => [1, dim]), [2, 1], [8, name], [9, Buffer.from(new Float32Array(values).buffer)]);
  const tensor = (name, dims) => {
    const shape = message(...dims.map((dim) => [1, message([1, dim])]));
    return message([1, name], [2, message([1, message([1, 1], [2, shape])])]);
  };
  const graph = message(
    [1, message([1, "photo"], [1, "red"], [2, "depth"], [4, "Conv"])],
    [2, "graph"],
    [5, weights("red", [1, 3, 1, 1], [1, 0, 0])],
    [5, weights("unused", [5e6], new Float32Array(5e6))],
    [11, tensor("photo", [1, 3, 256, 256])],
    [12, tensor("depth", [1, 1, 256, 256])],
  );
  return message([1, 8], [7, graph], [8, message([1, ""], [2, 13])]);
}

// An empty page with what the checks of the package share.
async function packagePage() {
  const page = await browser.newPage();
  await page.route("**/blank", (route) =>
    route.fulfill({
      contentType: "text/html",
      headers: { "Cross-Origin-Opener-Policy": "same-origin", "Cross-Origin-Embedder-Policy": "require-corp" },
      body: "<!doctype html><title>blank</title>",
    }),
  );
  await page.goto(`${site}/blank`);
  await page.evaluate(() => {
    globalThis.drawn = (bitmap) => {
      const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d", { alpha: false });
      context.drawImage(bitmap, 0, 0);
      return context.getImageData(0, 0, bitmap.width, bitmap.height);
    };
    globalThis.pixels = async (url) => drawn(await createImageBitmap(await (await fetch(url)).blob()));
    globalThis.decoded = async (file, numbers) => {
      const colours = { imageOrientation: "none", colorSpaceConversion: numbers ? "none" : "default" };
      return drawn(await createImageBitmap(new Blob([file]), colours));
    };
    // Grey of a picture or of its right half, as 64 x 64 means; less their mean.
    globalThis.means = async (url, half = false) => {
      const bitmap = await createImageBitmap(await (await fetch(url)).blob());
      const context = new OffscreenCanvas(64, 64).getContext("2d", { alpha: false });
      const left = half ? bitmap.width >> 1 : 0;
      context.imageSmoothingQuality = "high";
      context.drawImage(bitmap, left, 0, bitmap.width - left, bitmap.height, 0, 0, 64, 64);
      const values = [...context.getImageData(0, 0, 64, 64).data].filter((_, i) => i % 4 === 0);
      const mean = values.reduce((sum, value) => sum + value / values.length, 0);
      return values.map((value) => value - mean);
    };
    globalThis.correlation = (a, b) => {
      const product = (x, y) => x.reduce((sum, value, i) => sum + value * y[i], 0);
      return product(a, b) / Math.sqrt(product(a, a) * product(b, b));
    };
    globalThis.prepare = async (threads) => {
      const { load, storedDepth } = await import("/package/index.js");
      const altiro3d = await load(threads);
      const text = await (await fetch("/check/visual.json")).text();
      const display = new altiro3d.Display(text, "visual.json");
      const photo = await pixels("/check/photo.png");
      const width = photo.width >> 1;
      const height = photo.height >> 1;
      const data = new Uint16Array(width * height);
      for (let i = 0; i < data.length; ++i) data[i] = depthAt(i % width, Math.floor(i / width));
      const scene = new altiro3d.Scene(photo, { data, width, height });
      return { altiro3d, display, photo, scene, storedDepth };
    };
    // Blocks at different depths over a slope.
    globalThis.depthAt = (x, y) => 20 * y + ((x >> 6) + (y >> 6)) % 3 * 9000;
  });
  return page;
}
const depthAt = (x, y) => 20 * y + (((x >> 6) + (y >> 6)) % 3) * 9000; // as in the page

async function openedPage(context) {
  const page = await context.newPage();
  page.setDefaultTimeout(120e3); // for machines that do other work
  await page.goto(`${site}/page/`);
  await page.waitForSelector("body[data-ready]");
  return page;
}

async function choose(page, kind, file) {
  const chooser = page.waitForEvent("filechooser");
  await page.click(`aside [data-open=${kind}]`);
  await (await chooser).setFiles(file);
  await page.waitForFunction(() => document.body.ariaBusy === "false", undefined, { timeout: 120e3 });
}

async function drop(page, ...files) {
  const contents = files.map((file) => [basename(file), readFileSync(file).toString("base64")]);
  await page.evaluate(async (contents) => {
    const data = new DataTransfer();
    for (const [name, base64] of contents) {
      const blob = await (await fetch(`data:application/octet-stream;base64,${base64}`)).blob();
      data.items.add(new File([blob], name, { type: name.endsWith(".json") ? "application/json" : "image/png" }));
    }
    window.dispatchEvent(new DragEvent("drop", { dataTransfer: data, cancelable: true }));
  }, contents);
  await isDone(page);
}

const isDone = (page) =>
  page.waitForFunction(() => document.body.ariaBusy === "false", undefined, { timeout: 120e3 });

// A calibration of no sample.
function calibrationOf(serial) {
  writeFileSync(join(made, "own.json"), JSON.stringify({ ...JSON.parse(readFileSync(calibration)), serial }));
  return join(made, "own.json");
}

// Saves into the folder of the checks.
async function save(page, kind, name) {
  const download = page.waitForEvent("download");
  await page.click(`[data-save=${kind}]`);
  const file = await download;
  await file.saveAs(join(made, name));
  await isDone(page);
  return file.suggestedFilename();
}

// How alike the depth in a saved RGB-D picture is to another picture.
async function likeness(rgbd, other, isHalf = false) {
  const page = await packagePage();
  const files = [`/check/${rgbd}`, `/check/${other}`];
  const alike = await page.evaluate(
    async ([files, isHalf]) => correlation(await means(files[0], true), await means(files[1], isHalf)),
    [files, isHalf],
  );
  await page.close();
  return alike;
}

// A PNG or JPEG file that a canvas draws.
async function drawn(name, width, height, draw, type = "image/png") {
  const page = await packagePage();
  const base64 = await page.evaluate(
    async ({ width, height, draw, type }) => {
      const canvas = new OffscreenCanvas(width, height);
      await new Function("context", "width", "height", `return (async () => {${draw}})()`)(canvas.getContext("2d"), width, height);
      const bytes = new Uint8Array(await (await canvas.convertToBlob({ type })).arrayBuffer());
      let binary = "";
      for (const byte of bytes) binary += String.fromCharCode(byte);
      return btoa(binary);
    },
    { width, height, draw, type },
  );
  await page.close();
  writeFileSync(join(made, name), Buffer.from(base64, "base64"));
  return join(made, name);
}

const drawnSample = (name, width, height) =>
  drawn(
    name,
    width,
    height,
    'const photo = await createImageBitmap(await (await fetch("/check/sample.jpg")).blob());' +
      "context.drawImage(photo, 0, 0, width, height);",
    "image/jpeg",
  );
const slope = (colour) => // from black at the left to a colour at the right
  "const slope = context.createLinearGradient(0, 0, width, 0);" +
  `slope.addColorStop(0, "#000"); slope.addColorStop(1, "${colour}");` +
  "context.fillStyle = slope; context.fillRect(0, 0, width, height);";

// The processes of the browser that show pages: id, cpuTime in s.
async function renderers() {
  const session = await browser.newBrowserCDPSession();
  const { processInfo } = await session.send("SystemInfo.getProcessInfo");
  await session.detach();
  return processInfo.filter(({ type }) => type === "renderer");
}
const processorSeconds = async () => (await renderers()).reduce((sum, { cpuTime }) => sum + cpuTime, 0);

const text = (page, id) => page.textContent(`#${id}`);

const checks = {
  async "same pixels as photo2native"() {
    const page = await packagePage();
    // what the browser decodes of the sample photo is what both read
    const decoded = await page.evaluate(async (bytes) => {
      const blob = new Blob([Uint8Array.from(atob(bytes), (c) => c.charCodeAt(0))]);
      const photo = await pixels(URL.createObjectURL(blob));
      const canvas = new OffscreenCanvas(photo.width, photo.height);
      canvas.getContext("2d", { alpha: false }).putImageData(photo, 0, 0);
      const png = new Uint8Array(await (await canvas.convertToBlob()).arrayBuffer());
      let binary = "";
      for (const byte of png) binary += String.fromCharCode(byte);
      return { png: btoa(binary), width: photo.width, height: photo.height };
    }, readFileSync(sample).toString("base64"));
    writeFileSync(join(made, "photo.png"), Buffer.from(decoded.png, "base64"));
    writeFileSync(join(made, "depth.png"), greyPng(decoded.width >> 1, decoded.height >> 1, depthAt));
    const settings = [
      ["fast", { method: "fast", detail: "view" }, ["--method", "fast"]],
      ["layered", { method: "layered", detail: "view" }, ["--method", "layered"]],
      ["real", { method: "real", detail: "view" }, ["-g"]],
      ["usual", {}, []],
      ["given", { fit: "cover", focus: 0.3, strength: 14, detail: "view" }, "--quick --fit cover --focus 0.3 --strength 14".split(" ")],
    ];
    for (const [name, , options] of settings) {
      const files = ["photo.png", "depth.png", `${name}.png`].map((file) => join(made, file));
      execFileSync(photo2native, ["-y", "-c", calibration, ...options, "-d", ...files], { stdio: "pipe" });
    }
    for (const threads of [1, 4]) {
      const results = await page.evaluate(
        async ({ threads, settings }) => {
          const { altiro3d, display, scene } = await prepare(threads);
          const results = [];
          for (const [name, options] of settings) {
            const rendering = new altiro3d.Rendering(display, scene, options);
            const begin = performance.now();
            const native = rendering.native();
            const milliseconds = Math.round(performance.now() - begin);
            const png = URL.createObjectURL(new Blob([rendering.nativePng()], { type: "image/png" }));
            const saved = await pixels(png);
            rendering.delete();
            const expected = await pixels(`/check/${name}.png`);
            const count = (picture) => picture.data.reduce((sum, value, i) => sum + (value !== expected.data[i]), 0);
            const size = `${native.width} x ${native.height}`;
            results.push({ name, size, milliseconds, different: count(native) + count(saved) });
          }
          return results;
        },
        { threads, settings },
      );
      for (const { name, size, milliseconds, different } of results) {
        console.log(`    ${name}, ${threads} threads: ${milliseconds} ms, ${different} values differ`);
        assert.equal(size, "1536 x 2048");
        assert.equal(different, 0, `${name}: values differ`);
      }
    }
    await page.close();
  },

  async "depth in photos, and pairs, as photo2native"() {
    const page = await packagePage();
    const file = (name) => join(made, name);
    const run = (...options) => execFileSync(photo2native, ["-y", ...options], { stdio: "pipe" });
    const parts = [file("photo.png"), file("depth.png"), file("given.png")];
    run("-c", calibration, "--save-stereo", file("pair_LRF.png"), "--save-photo-with-depth", file("phone.jpg"), "-d", ...parts);
    run("-c", calibration, "--save-stereo", file("eye.jpg"), "--stereo-layout", "files", "-d", ...parts);
    const [phone, left, right] = ["phone.jpg", "eye_L.jpg", "eye_R.jpg"].map((name) => readFileSync(file(name)));
    writeFileSync(file("turned.jpg"), withSegment(phone, 0xe1, exif(6)));
    writeFileSync(file("linear.jpg"), withSegment(left, 0xe1, gDepth(greyPng(30, 40, (x, y) => 257 * (6 * y + x % 5)))));
    writeFileSync(file("eyes.mpo"), mpo(left, right));
    const marked = readFileSync(file("pair_LRF.png")); // the mark is the chunk tEXt behind IHDR
    const [ihdrEnd, markEnd] = [33, 33 + 12 + marked.readUInt32BE(33)];
    writeFileSync(file("named_LRF.png"), Buffer.concat([marked.subarray(0, ihdrEnd), marked.subarray(markEnd)]));
    writeFileSync(file("odd_LR.png"), readFileSync(file("photo.png"))); // not a pair, in spite of its name
    for (const [name, expected] of [
      ["phone.jpg", "depth in the photo's file (Dynamic Depth, "],
      ["turned.jpg", "depth in the photo's file (Dynamic Depth, "],
      ["linear.jpg", "depth in the photo's file (Google lens blur, 30 x 40 px)"],
      ["eyes.mpo", "stereo pair (MPO), depth by matching; "],
      ["pair_LRF.png", "stereo pair (mark of altiro3D), depth by matching; "],
      ["named_LRF.png", "stereo pair (left and right half, by its name, LRF), depth by matching; "],
      ["odd_LR.png", ""],
    ]) {
      if (expected) run("-c", calibration, file(name), file("native.png"));
      for (const threads of [1, 4]) {
        const { different, most, text, remarks } = await page.evaluate(
          async ({ name, threads }) => {
            const { altiro3d, display, storedDepth } = await prepare(threads);
            const bytes = new Uint8Array(await (await fetch(`/check/${name}`)).arrayBuffer());
            const { scene, text, remarks } = await storedDepth(altiro3d, bytes, name, await pixels(`/check/${name}`), decoded);
            if (!scene) return { different: 0, most: 0, text, remarks };
            const rendering = new altiro3d.Rendering(display, scene, {});
            const native = rendering.native();
            const expected = await pixels("/check/native.png");
            const differences = native.data.map((value, i) => Math.abs(value - expected.data[i]));
            const different = differences.reduce((sum, value) => sum + (value > 0), 0);
            return { different, most: Math.max(...new Set(differences)), text, remarks };
          },
          { name, threads },
        );
        console.log(`    ${name}, ${threads} threads: ${different} values differ, by at most ${most}; ${text}${remarks.join("; ")}`);
        assert.ok(text.startsWith(expected));
        assert.equal(remarks.length, expected ? 0 : 1);
        assert.equal(different, 0);
      }
    }
    await page.close();
    const context = await browser.newContext();
    const opened = await openedPage(context);
    await choose(opened, "photo", file("pair_LRF.png"));
    assert.match(await text(opened, "status"), /pair_LRF.png: .* s; stereo pair \(mark of altiro3D\)/);
    const download = opened.waitForEvent("download");
    await opened.click("[data-save=rgbd]");
    await (await download).saveAs(file("pair_rgbd.png"));
    // one eye and its depth are as wide as both eyes
    assert.deepEqual(readFileSync(file("pair_rgbd.png")).subarray(16, 24), readFileSync(file("pair_LRF.png")).subarray(16, 24));
    await context.close();
  },

  async "memory stays flat over 500 renderings"() {
    const page = await packagePage();
    const used = await page.evaluate(async () => {
      const { altiro3d, display, scene } = await prepare(1);
      const used = [];
      for (let i = 0; i < 500; ++i) {
        const rendering = new altiro3d.Rendering(display, scene, { method: i % 2 ? "fast" : "layered", detail: "view" });
        rendering.native();
        rendering.view(0.5, 200);
        rendering.delete();
        try {
          new altiro3d.Rendering(display, scene, { method: "none" });
        } catch {
          // also errors must not leak
        }
        if (i === 99 || i === 499) used.push(altiro3d.memoryInUse());
      }
      return used;
    });
    console.log(`    in use after 100: ${used[0]} bytes, after 500: ${used[1]}`);
    assert.ok(Math.abs(used[1] - used[0]) < 16384);
    await page.close();
  },

  async "errors are sentences"() {
    const page = await packagePage();
    const errors = await page.evaluate(async () => {
      const { altiro3d, display, photo, scene } = await prepare(1);
      const told = (work) => {
        try {
          return work();
        } catch (error) {
          return `${error.constructor.name}: ${error.message}`;
        }
      };
      return [
        told(() => new altiro3d.Display('{"pitch": 1}', "visual.json")),
        told(() => new altiro3d.Scene(photo, { data: new Float32Array(5), width: 2, height: 2 })),
        told(() => new altiro3d.Scene(photo, { data: [1], width: 1, height: 1 })),
        told(() => new altiro3d.Rendering(display, scene, { method: "slow" })),
        told(() => new altiro3d.Rendering(display, scene, { focus: 2 })),
      ];
    });
    for (const error of errors) {
      console.log(`    ${error}`);
      assert.match(error, /^Error: .*: .*, expected /);
    }
    await page.close();
  },

  async "a photo is opened, sways, and is saved"() {
    const context = await browser.newContext({ viewport: { width: 1280, height: 800 } });
    const page = await openedPage(context);
    assert.equal(await page.evaluate(() => crossOriginIsolated), true);
    await page.screenshot({ path: join(made, "start.png") });
    const photo = await drawnSample("two.jpg", 1632, 1224);
    const begin = performance.now();
    const used = await processorSeconds();
    await drop(page, photo);
    await page.waitForFunction(() => document.getElementById("view").dataset.position !== undefined);
    const milliseconds = Math.round(performance.now() - begin);
    const seconds = (await processorSeconds()) - used;
    console.log(`    first picture of 2 MP after ${milliseconds} ms and ${seconds.toFixed(1)} s of processor time`);
    assert.ok(seconds < 6); // of two threads, 2 at rest
    assert.equal(await page.isHidden("#error"), true);
    const seen = async (x) => {
      const box = await page.locator("#view").boundingBox();
      await page.mouse.move(box.x + x * box.width, box.y + box.height / 2);
      const position = (2 * x - 1).toFixed(1);
      await page.waitForFunction((wanted) => Math.abs(document.getElementById("view").dataset.position - wanted) < 0.02, position);
      return page.evaluate(() => document.getElementById("view").toDataURL());
    };
    const left = await seen(0.05);
    const right = await seen(0.95);
    assert.notEqual(left, right);
    assert.equal(await seen(0.05), left);
    await page.screenshot({ path: join(made, "light.png") });
    for (const [kind, name] of [["native", "two-native.png"], ["quilt", "two_qs8x6a0.75.png"], ["rgbd", "two_rgbd.png"], ["video", "two.webm"]])
      assert.equal(await save(page, kind, name), name);
    await page.emulateMedia({ colorScheme: "dark" });
    await page.screenshot({ path: join(made, "dark.png") });
    await context.close();
  },

  async "the depth is that of photo2native"() {
    const context = await browser.newContext();
    const page = await openedPage(context);
    await choose(page, "photo", sample);
    await save(page, "rgbd", "estimated_rgbd.png");
    execFileSync(photo2native, ["-y", "-c", calibration, "-n", "altiro3d", "--save-depth", join(made, "estimated.png"), sample, join(made, "native.png")], { stdio: "pipe" });
    const alike = await likeness("estimated_rgbd.png", "estimated.png");
    console.log(`    correlation ${alike.toFixed(4)}`);
    assert.ok(alike > 0.99);
    await context.close();
  },

  async "several photos, each with its depth"() {
    const context = await browser.newContext({ viewport: { width: 1280, height: 800 } });
    const page = await openedPage(context);
    const photos = [await drawnSample("a.png", 600, 800), await drawnSample("b.png", 800, 600), join(made, "c.png")];
    writeFileSync(photos[2], "broken");
    const depths = [await drawn("b-depth.png", 80, 60, slope("#fff")), await drawn("none-depth.png", 80, 60, slope("#ccc"))];
    await drop(page, depths[0], ...photos);
    assert.match(await text(page, "status"), /^a\.png/);
    const pressed = async (key) => {
      await page.keyboard.press(key);
      await isDone(page);
      return [await text(page, "status"), await page.getAttribute("#photos [aria-current=true]", "title")].join(" ");
    };
    assert.match(await pressed("PageDown"), /^b\.png with b-depth\.png: ready .* b\.png$/);
    await page.waitForSelector("#photos button:nth-child(2) canvas");
    await page.screenshot({ path: join(made, "several.png") });
    assert.equal(await save(page, "rgbd", "b_rgbd.png"), "b_rgbd.png");
    const alike = await likeness("b_rgbd.png", "b-depth.png");
    console.log(`    correlation of its depth ${alike.toFixed(4)}`);
    assert.ok(alike > 0.99);
    // a broken one is told and goes, the open one stays
    assert.match(await pressed("PageDown"), /^b\.png/);
    assert.match(await text(page, "error"), /^c\.png: .*, expected/);
    assert.equal(await page.locator("#photos button").count(), 2);
    await page.screenshot({ path: join(made, "error.png") });
    // opened by the button of its kind, whatever its name
    await choose(page, "photo", depths[0]);
    assert.match(await text(page, "status"), /^b-depth\.png: ready/);
    await pressed("PageUp");
    // each keeps its settings
    await page.selectOption("#fit", "contain");
    assert.match(await pressed("PageUp"), /^a\.png/);
    assert.equal(await page.inputValue("#fit"), "auto");
    await page.click("#photos button:nth-child(2)");
    await isDone(page);
    assert.equal(await page.inputValue("#fit"), "contain");
    // a depth without a photo of its name is that of the open one
    await drop(page, depths[1]);
    assert.equal(await page.isHidden("#error"), true);
    // in full screen, arrows turn the pages
    await page.click("#show");
    await page.waitForFunction(() => document.fullscreenElement?.id === "panel");
    assert.match(await pressed("ArrowLeft"), /^a\.png/);
    assert.match(await pressed(" "), /^b\.png/);
    await page.keyboard.press("f");
    await page.waitForFunction(() => !document.fullscreenElement);
    await page.setViewportSize({ width: 390, height: 844 });
    await page.screenshot({ path: join(made, "phone.png"), fullPage: true });
    await context.close();
  },

  async "depth comes from RGB-D pictures and larger networks"() {
    const context = await browser.newContext();
    const page = await openedPage(context);
    const halves =
      'context.fillStyle = "#345"; context.fillRect(0, 0, width, height); context.translate(width / 2, 0);' +
      "width /= 2;" + slope("#fff");
    await drop(page, await drawn("halves_rgbd.png", 640, 480, halves));
    await save(page, "rgbd", "saved_rgbd.png");
    let alike = await likeness("saved_rgbd.png", "halves_rgbd.png", true);
    console.log(`    RGB-D: correlation ${alike.toFixed(4)}`);
    assert.ok(alike > 0.999);
    // green and blue would mislead a network that looks at more than red
    const colours =
      'context.globalCompositeOperation = "lighter";' + slope("#f00") +
      'context.fillStyle = "#0a6"; context.fillRect(0, height / 2, width, height);';
    await drop(page, await drawn("colours.png", 640, 480, colours));
    await drawn("red.png", 640, 480, slope("#fff"));
    writeFileSync(join(made, "model-small.onnx"), redNetwork());
    await drop(page, join(made, "model-small.onnx"));
    assert.equal(await page.isHidden("#error"), true, await text(page, "error"));
    assert.match(await text(page, "network"), /model-small.*processor/);
    await save(page, "rgbd", "colours_rgbd.png");
    alike = await likeness("colours_rgbd.png", "red.png");
    console.log(`    network of 20 MB: correlation ${alike.toFixed(4)}`);
    assert.ok(alike > 0.99);
    await context.close();
  },

  async "networks run on the graphics card"() {
    const other = await launch("--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader");
    const context = await other.newContext({ serviceWorkers: "block" });
    // the only card here is a program, which the page refuses
    await context.route("**/worker.js", async (route) => {
      const response = await route.fetch();
      await route.fulfill({ response, body: (await response.text()).replace("isFallbackAdapter", "isNothing") });
    });
    const page = await openedPage(context);
    await choose(page, "photo", await drawn("red.png", 640, 480, slope("#f00")));
    writeFileSync(join(made, "model-small.onnx"), redNetwork());
    await choose(page, "network", join(made, "model-small.onnx"));
    console.log(`    ${await text(page, "status")} ${await text(page, "network")} ${await text(page, "error")}`);
    assert.match(await text(page, "network"), /graphics card/);
    await save(page, "rgbd", "gpu_rgbd.png");
    assert.ok((await likeness("gpu_rgbd.png", "red.png")) > 0.99);
    await other.close();
  },

  async "samples of all models"() {
    const context = await browser.newContext();
    const page = await openedPage(context);
    await drop(page, sample, calibrationOf("LKG-P99999"));
    assert.equal(await page.isHidden("#warning"), true);
    const names = await page.locator("#sample optgroup option").evaluateAll((options) => options.map(({ value }) => value));
    console.log(`    ${names.join(", ")}`);
    assert.ok(names.length > 8);
    for (const name of names) {
      await page.selectOption("#sample", name);
      await isDone(page);
      assert.equal(await page.isHidden("#error"), true);
      assert.ok((await text(page, "display")).startsWith(`${name}: `), await text(page, "display"));
      assert.equal(await page.isVisible("#warning"), true);
    }
    await page.reload();
    await page.waitForSelector("body[data-ready]");
    assert.equal(await page.inputValue("#sample"), names.at(-1));
    // the calibration that was opened is still there
    await page.selectOption("#sample", "");
    await isDone(page);
    assert.match(await text(page, "display"), /LKG-P99999/);
    assert.equal(await page.isHidden("#warning"), true);
    await context.close();
  },

  async "tilting is asked for where it must be"() {
    const context = await browser.newContext({ hasTouch: true });
    await context.addInitScript(() => {
      DeviceOrientationEvent.requestPermission = async () => globalThis.answer ?? "denied";
    });
    const page = await openedPage(context);
    await choose(page, "photo", sample);
    await page.click("#tilt");
    await page.waitForSelector("#error:not([hidden])");
    assert.match(await text(page, "error"), /^Tilt: .*, expected/);
    await page.evaluate(() => (globalThis.answer = "granted"));
    await page.click("#tilt");
    await page.waitForSelector("#tilt", { state: "hidden" });
    for (const gamma of [0, 20])
      await page.evaluate((gamma) => window.dispatchEvent(new DeviceOrientationEvent("deviceorientation", { beta: 40, gamma })), gamma);
    await page.waitForFunction(() => document.getElementById("view").dataset.position === "0.800");
    await context.close();
  },

  async "controls have names, and states are told"() {
    const context = await browser.newContext();
    const page = await openedPage(context);
    await drop(page, await drawnSample("a.png", 600, 800), await drawnSample("b.png", 800, 600));
    await page.waitForSelector("#photos button:nth-child(2) canvas");
    const session = await context.newCDPSession(page);
    const { nodes } = await session.send("Accessibility.getFullAXTree");
    const controls = nodes.filter(({ ignored, role }) => !ignored && /^(button|checkbox|combobox|slider|image|img)$/i.test(role?.value));
    console.log(`    ${controls.map(({ role, name }) => `${role.value} "${name?.value}"`).join(", ")}`);
    assert.ok(controls.length >= 20);
    for (const { role, name } of controls) assert.ok(name?.value.trim(), `${role.value} without a name`);
    assert.equal(new Set(controls.map(({ role, name }) => role.value + name.value)).size, controls.length, "names differ");
    const live = (id) => page.evaluate((id) => document.getElementById(id).role ?? document.getElementById(id).getAttribute("role"), id);
    assert.deepEqual(await Promise.all(["status", "error", "warning", "screen"].map(live)), ["status", "alert", "status", "status"]);
    await context.close();
  },

  async "full screen is asked for on the screen of the panel"() {
    const other = await launch("--screen-info={0,0 1600x900}{1600,0 1536x2048}");
    const context = await other.newContext({ viewport: null });
    await context.addInitScript(() => {
      const request = Element.prototype.requestFullscreen;
      Element.prototype.requestFullscreen = function (options) {
        globalThis.asked = options.screen && [options.screen.left, options.screen.width, options.screen.height];
        return request.call(this, options);
      };
    });
    const page = await openedPage(context);
    const session = await context.newCDPSession(page);
    const { targetInfo } = await session.send("Target.getTargetInfo");
    const { browserContextId } = targetInfo;
    await (await other.newBrowserCDPSession()).send("Browser.grantPermissions", { permissions: ["windowManagement"], origin: site, browserContextId });
    await choose(page, "photo", sample);
    await page.keyboard.press("f");
    await page.waitForFunction(() => document.fullscreenElement?.id === "panel" && document.getElementById("native").width === 1536);
    assert.deepEqual(await page.evaluate(() => globalThis.asked), [1600, 1536, 2048]);
    // a browser without screen does not move the window there, which the page tells
    assert.match(await text(page, "misfit"), /1600 × 900 px, expected 1536 × 2048/);
    await other.close();
  },

  async "broken files are told, and nothing is lost"() {
    const context = await browser.newContext();
    const page = await openedPage(context);
    await choose(page, "photo", sample);
    const broken = join(made, "broken.jpg");
    writeFileSync(broken, readFileSync(sample).subarray(0, 300));
    writeFileSync(join(made, "broken.json"), "{");
    writeFileSync(join(made, "altiro3d-depth.onnx"), "no network");
    for (const [kind, file] of [["photo", broken], ["calibration", join(made, "broken.json")], ["network", join(made, "altiro3d-depth.onnx")], ["depth", broken]]) {
      await choose(page, kind, file);
      const error = await text(page, "error");
      console.log(`    ${error}`);
      assert.match(error, /^[^ ]+: .*, expected /);
      assert.equal(await page.isVisible("#view"), true);
    }
    writeFileSync(join(made, "beside-depth.png"), "broken");
    await drop(page, await drawnSample("beside.png", 600, 800), join(made, "beside-depth.png"));
    assert.match(await text(page, "error"), /^beside-depth\.png: .*, expected /);
    assert.equal(await text(page, "status"), "beside.png");
    await choose(page, "depth", await drawn("b-depth.png", 80, 60, slope("#fff")));
    assert.equal(await page.isHidden("#error"), true);
    await context.close();
  },

  async "a calibration is kept; F shows px by px"() {
    const context = await browser.newContext({ viewport: { width: 1536, height: 2048 }, screen: { width: 1536, height: 2048 } });
    const page = await openedPage(context);
    assert.equal(await page.isVisible("#warning"), true);
    await choose(page, "calibration", calibrationOf("LKG-P99999"));
    await page.reload();
    await page.waitForSelector("body[data-ready]");
    assert.equal(await page.isVisible("#warning"), false);
    await choose(page, "photo", sample);
    await page.keyboard.press("f");
    await page.waitForFunction(() => document.fullscreenElement?.id === "panel" && document.getElementById("native").width === 1536);
    const shown = await page.evaluate(() => {
      const box = document.getElementById("native").getBoundingClientRect();
      return [box.x, box.y, box.width, box.height, devicePixelRatio];
    });
    assert.deepEqual(shown, [0, 0, 1536, 2048, 1]);
    await context.close();
  },

  async "works without network after the first visit"() {
    const context = await browser.newContext();
    const page = await openedPage(context);
    await page.evaluate(() => navigator.serviceWorker.ready);
    await page.reload();
    await page.waitForSelector("body[data-ready]");
    await context.setOffline(true);
    await page.reload();
    await page.waitForSelector("body[data-ready]");
    await choose(page, "photo", sample);
    assert.equal(await page.isHidden("#error"), true);
    await context.close();
  },

  async "a photo of 12 MP needs less than 1 GB"() {
    const context = await browser.newContext();
    const page = await openedPage(context);
    await drawnSample("large.jpg", 3000, 4000);
    await choose(page, "photo", join(made, "large.jpg"));
    assert.equal(await page.isHidden("#error"), true);
    const sizes = (await renderers()).map(({ id }) =>
      Number(/VmHWM:\s+(\d+)/.exec(readFileSync(`/proc/${id}/status`, "latin1"))[1]),
    );
    const most = Math.max(...sizes); // kB, of the largest process
    console.log(`    ${await text(page, "status")}; at most ${Math.round(most / 1024)} MiB`);
    assert.ok(most > 0 && most < 1024 * 1024);
    await context.close();
  },
};

let failed = 0;
for (const [name, check] of Object.entries(checks)) {
  if (words.length && !words.some((word) => name.includes(word))) continue;
  console.log(name);
  try {
    await check();
  } catch (error) {
    console.log(`    FAILED: ${error.stack}`);
    ++failed;
  }
}
await browser.close();
server.close();
process.exitCode = failed ? 1 : 0;
