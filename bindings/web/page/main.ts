import type { Chosen, DisplayFacts, Options, Picture } from "altiro3d";
import type { Calls } from "./worker";

const $ = <T extends HTMLElement>(id: string) => document.getElementById(id) as T;
const view = $<HTMLCanvasElement>("view");
const panel = $<HTMLDivElement>("panel");
const native = $<HTMLCanvasElement>("native");
const strength = $<HTMLInputElement>("strength");
const focus = $<HTMLInputElement>("focus");
const fit = $<HTMLSelectElement>("fit");
const method = $<HTMLSelectElement>("method");
const swing = $<HTMLInputElement>("swing");
const chooser = $<HTMLInputElement>("file");

// The worker

const worker = new Worker("worker.js", { type: "module" });
const waiting = new Map<number, [(value: never) => void, (error: Error) => void]>();
let calls = 0;

function call<Name extends keyof Calls>(
  name: Name,
  ...args: Parameters<Calls[Name]>
): Promise<Awaited<ReturnType<Calls[Name]>>> {
  return new Promise((resolve, reject) => {
    waiting.set(++calls, [resolve, reject]);
    worker.postMessage([calls, name, args]);
  });
}

worker.onmessage = ({ data: [id, result, error] }) => {
  const [resolve, reject] = waiting.get(id)!;
  waiting.delete(id);
  if (error === undefined) resolve(result as never);
  else reject(new Error(error));
};
worker.onerror = () => say("", "The page could not be loaded, expected a browser with WebAssembly SIMD.");

function say(status: string, error = ""): void {
  $("status").textContent = status;
  $("error").textContent = error;
  $("error").hidden = error === "";
}

// Runs what a user asks for; what is wrong is told, and all stays as it was.
async function perform(status: string, work: () => Promise<unknown>): Promise<void> {
  document.body.ariaBusy = "true";
  say(status);
  const begin = performance.now();
  try {
    await work();
    const remarks = (await call("remarks")).map((remark) => `; ${remark}`).join("");
    say(photoName && `${photoName}: ${((performance.now() - begin) / 1000).toFixed(1)} s${remarks}`);
  } catch (error) {
    say(photoName, (error as Error).message);
  }
  document.body.ariaBusy = "false";
}

// Display

let display: DisplayFacts;
const storedCalibration = "altiro3d.calibration";

async function calibrate(text: string, name: string, isSample = false): Promise<void> {
  display = await call("calibrate", text, name);
  const model = display.model || "Unknown display";
  $("display").textContent =
    `${model}${display.serial && `, ${display.serial}`}: ${display.width} × ${display.height} px. ` +
    display.remarks.join(" ");
  $("sample").hidden = !isSample;
  if (!isSample) localStorage.setItem(storedCalibration, text);
  redraw();
}

// Photo and settings

let photoName = "";
let automatic = true; // strength and focus follow from the picture

function options(): Options {
  const chosen: Options = {
    fit: fit.value as Options["fit"],
    method: method.value as Options["method"],
  };
  if (!automatic) {
    chosen.strength = strength.valueAsNumber;
    chosen.focus = focus.valueAsNumber;
  }
  return chosen;
}

function showChosen(chosen: Chosen | undefined): void {
  if (!chosen) return;
  strength.value = String(chosen.strength);
  focus.value = String(chosen.focus);
  $("strengthText").textContent = chosen.strength.toFixed(1);
  $("focusText").textContent = chosen.focus.toFixed(2);
  redraw();
}

async function apply(): Promise<void> {
  try {
    showChosen(await call("set", options()));
  } catch (error) {
    say(photoName, (error as Error).message);
  }
}

async function openPhoto(file: File, kind: "open" | "openRgbd"): Promise<void> {
  await perform(`${file.name}: reading, and estimating depth …`, async () => {
    const chosen = await call(kind, file);
    photoName = file.name;
    $<HTMLFieldSetElement>("settings").disabled = $<HTMLFieldSetElement>("save").disabled = false;
    $<HTMLButtonElement>("show").disabled = false;
    view.classList.add("shown");
    showChosen(chosen);
  });
}

const kinds = {
  photo: { accept: "image/*", open: (file: File) => openPhoto(file, "open") },
  rgbd: { accept: "image/*", open: (file: File) => openPhoto(file, "openRgbd") },
  depth: {
    accept: "image/*",
    open: (file: File) => perform(`${file.name} …`, async () => showChosen(await call("openDepth", file))),
  },
  network: {
    accept: ".onnx",
    open: (file: File) => perform(`${file.name} …`, async () => showChosen(await call("openNetwork", file))),
  },
  calibration: {
    accept: ".json",
    open: (file: File) => perform(`${file.name} …`, async () => calibrate(await file.text(), file.name)),
  },
};

// Files that are dropped or pasted: their names tell what they are.
async function openAll(files: Iterable<File>): Promise<void> {
  for (const file of files) {
    const name = file.name.toLowerCase();
    const isDepth = photoName !== "" && /[-_.]depth\.\w+$/.test(name);
    const kind = name.endsWith(".json")
      ? "calibration"
      : name.endsWith(".onnx")
        ? "network"
        : isDepth
          ? "depth"
          : /rgbd\.\w+$/.test(name)
            ? "rgbd"
            : "photo";
    await kinds[kind].open(file);
  }
}

// Sway: one view is asked for at a time, for the latest position.

let position = 0;
let shown = NaN; // position of the view on the screen
let isAsking = false;

function redraw(): void {
  shown = NaN;
  if (document.fullscreenElement === panel) void drawNative();
}

function draw(picture: Picture, canvas: HTMLCanvasElement): void {
  canvas.width = picture.width;
  canvas.height = picture.height;
  const image = new ImageData(picture.data as Uint8ClampedArray<ArrayBuffer>, picture.width, picture.height);
  canvas.getContext("2d", { alpha: false })!.putImageData(image, 0, 0);
}

async function drawView(wanted: number): Promise<void> {
  isAsking = true;
  const height = Math.min(1200, Math.round(($("stage").clientHeight - 32) * devicePixelRatio));
  try {
    draw(await call("view", wanted, Math.max(64, height)), view);
    view.dataset.position = wanted.toFixed(3);
  } catch (error) {
    say(photoName, (error as Error).message);
  }
  shown = wanted;
  isAsking = false;
}

function tick(milliseconds: number): void {
  if (swing.checked) position = Math.sin(milliseconds / 700);
  if (photoName && !isAsking && position !== shown && document.fullscreenElement !== panel) void drawView(position);
  requestAnimationFrame(tick);
}

function look(share: number): void {
  swing.checked = false;
  position = Math.max(-1, Math.min(1, 2 * share - 1));
}

// Show on the display

async function drawNative(): Promise<void> {
  draw(await call("native"), native);
  fitPanel();
}

// One px of the canvas on one px of the panel.
function fitPanel(): void {
  native.style.width = `${native.width / devicePixelRatio}px`;
  native.style.height = `${native.height / devicePixelRatio}px`;
  const columns = Math.round(screen.width * devicePixelRatio);
  const rows = Math.round(screen.height * devicePixelRatio);
  const fits = columns === native.width && rows === native.height;
  $("screen").hidden = fits;
  $("screen").textContent = fits
    ? ""
    : `The screen has ${columns} × ${rows} px, expected ${native.width} × ${native.height}: move this window to the ` +
      "display, set its scaling and the zoom of the page to 100 %, and press F there.";
}

interface DetailedScreen extends Screen {
  devicePixelRatio: number;
}

async function show(): Promise<void> {
  const request: FullscreenOptions & { screen?: Screen } = { navigationUI: "hide" };
  const windowWithScreens = window as Window & { getScreenDetails?: () => Promise<{ screens: DetailedScreen[] }> };
  try {
    const screens = (await windowWithScreens.getScreenDetails?.())?.screens ?? [];
    request.screen = screens.find(
      (one) =>
        Math.round(one.width * one.devicePixelRatio) === display.width &&
        Math.round(one.height * one.devicePixelRatio) === display.height,
    );
  } catch {
    // not allowed: on the screen of this window
  }
  panel.hidden = false;
  try {
    await panel.requestFullscreen(request);
    await drawNative();
  } catch (error) {
    say(photoName, `Full screen: ${(error as Error).message}`);
  }
}

// Save

function save(contents: Blob, name: string): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(contents);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60e3);
}

async function pngOf(picture: Picture): Promise<Blob> {
  const canvas = document.createElement("canvas");
  draw(picture, canvas);
  return new Promise((resolve) => canvas.toBlob((blob) => resolve(blob!), "image/png"));
}

// One turn of the camera, recorded while it is shown.
async function recordTurn(): Promise<Blob> {
  const seconds = 4;
  const canvas = document.createElement("canvas");
  const stem = await call("view", 0, 960);
  draw(stem, canvas);
  const recorder = new MediaRecorder(canvas.captureStream(30), { videoBitsPerSecond: 12e6 });
  const parts: Blob[] = [];
  recorder.ondataavailable = ({ data }) => parts.push(data);
  const stopped = new Promise((resolve) => (recorder.onstop = resolve));
  recorder.start();
  const begin = performance.now();
  for (let time = 0; time < seconds; time = (performance.now() - begin) / 1000) {
    draw(await call("view", Math.sin((2 * Math.PI * time) / seconds), 960), canvas);
    await new Promise(requestAnimationFrame);
  }
  recorder.stop();
  await stopped;
  return new Blob(parts, { type: "video/webm" });
}

const stem = () => photoName.replace(/\.\w+$/, "");
const png = { type: "image/png" };
const saves = {
  native: async () => save(new Blob([(await call("nativePng")) as BlobPart], png), `${stem()}-native.png`),
  quilt: async () => save(new Blob([(await call("quiltPng")) as BlobPart], png), await call("quiltName")),
  rgbd: async () => save(await pngOf(await call("rgbd")), `${stem()}_rgbd.png`),
  video: async () => save(await recordTurn(), `${stem()}.webm`),
};

// Events

document.addEventListener("click", ({ target }) => {
  const button = (target as HTMLElement).closest<HTMLElement>("[data-open], [data-save]");
  if (button?.dataset.save) {
    void perform("Saving …", saves[button.dataset.save as keyof typeof saves]);
  } else if (button?.dataset.open) {
    const kind = kinds[button.dataset.open as keyof typeof kinds];
    chooser.accept = kind.accept;
    chooser.value = "";
    chooser.onchange = () => void kind.open(chooser.files![0]);
    chooser.click();
  }
});
window.addEventListener("dragover", (event) => {
  event.preventDefault();
  $("stage").classList.add("over");
});
window.addEventListener("dragleave", () => $("stage").classList.remove("over"));
window.addEventListener("drop", (event) => {
  event.preventDefault();
  $("stage").classList.remove("over");
  void openAll([...(event.dataTransfer?.files ?? [])]);
});
window.addEventListener("paste", (event) => void openAll([...(event.clipboardData?.files ?? [])]));
view.addEventListener("pointermove", (event) => look(event.offsetX / view.clientWidth));
window.addEventListener("deviceorientation", ({ gamma }) => {
  if (gamma !== null) look(0.5 + gamma / 50);
});
window.addEventListener("resize", () => {
  if (document.fullscreenElement === panel) fitPanel();
});
for (const slider of [strength, focus]) {
  slider.addEventListener("input", () => {
    automatic = false;
    void apply();
  });
}
for (const choice of [fit, method]) choice.addEventListener("change", () => void apply());
$("reset").addEventListener("click", () => {
  automatic = true;
  fit.value = "auto";
  void apply();
});
$("show").addEventListener("click", () => void show());
window.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || event.target instanceof HTMLSelectElement) return;
  if (event.key === "f" && photoName) void show();
  const isFree = event.target === document.body || event.target === view;
  if (!isFree) return;
  if (event.key === " ") swing.checked = !swing.checked;
  else if (event.key === "ArrowLeft") look((position + 1) / 2 - 0.05);
  else if (event.key === "ArrowRight") look((position + 1) / 2 + 0.05);
  else return;
  event.preventDefault();
});

// Start

async function start(): Promise<void> {
  const { version, threads } = await call("start");
  const stored = localStorage.getItem(storedCalibration);
  const sample = await (await fetch("portrait-sample.json")).text();
  try {
    await calibrate(stored ?? sample, stored ? "stored calibration" : "portrait-sample.json", !stored);
  } catch {
    await calibrate(sample, "portrait-sample.json", true);
  }
  say(`Version ${version}${threads ? "" : ", on one thread"}`);
  document.body.dataset.ready = "true";
  requestAnimationFrame(tick);
}

void start().catch((error: Error) => say("", error.message));
void navigator.serviceWorker?.register("sw.js");
