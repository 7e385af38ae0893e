import type { Chosen, DisplayFacts, Options, Picture } from "altiro3d";
import { type Photo, pairs, photoOf, stemOf, thumbnailOf } from "./photos";
import { sampleEnding, sampleNames, sampleOf } from "./samples";
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
const sample = $<HTMLSelectElement>("sample");
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

// Runs what a user asks for; what is wrong is told and returned, and all stays as it was.
async function perform(status: string, work: () => Promise<unknown>): Promise<string> {
  document.body.ariaBusy = "true";
  say(status);
  const begin = performance.now();
  let wrong = "";
  try {
    await work();
    const remarks = (await call("remarks")).map((remark) => `; ${remark}`).join("");
    const seconds = ((performance.now() - begin) / 1000).toFixed(1);
    say(current ? `${named(current)}: ready in ${seconds} s${remarks}` : "");
  } catch (error) {
    wrong = (error as Error).message;
    tell(error);
  }
  document.body.ariaBusy = "false";
  return wrong;
}

const named = ({ name, depth }: Photo) => (depth instanceof File ? `${name} with ${depth.name}` : name);

function tell(error: unknown): void {
  say(current?.name ?? "", (error as Error).message);
}

// Display

let display: DisplayFacts;
// Kept in the browser: the calibration that was opened last, and the sample that is used instead of it.
const kept = { own: "altiro3d.calibration", sample: "altiro3d.sample" };

async function calibrate(text: string, name: string): Promise<void> {
  display = await call("calibrate", text, name);
  const model = display.model || "Unknown display";
  const isSample = display.serial.endsWith(sampleEnding);
  $("display").textContent =
    `${model}${display.serial && !isSample ? `, ${display.serial}` : ""}: ${display.width} × ${display.height} px. ` +
    display.remarks.join(" ");
  $("warning").hidden = !isSample;
  if (!isSample) {
    localStorage.setItem(kept.own, text);
    sample.options[0].text = $("display").textContent!.split(":")[0];
    sample.options[0].hidden = false;
  }
  sample.value = isSample ? model : "";
  localStorage.setItem(kept.sample, sample.value);
  redraw();
}

// Photos

const photos: Photo[] = [];
const buttons = new Map<Photo, HTMLButtonElement>();
let current: Photo | undefined;

function add(photo: Photo): void {
  photos.push(photo);
  const button = thumbnailOf(photo, () => void openPhoto(photo));
  buttons.set(photo, button);
  $("photos").append(button);
}

function remove(photo: Photo): void {
  photos.splice(photos.indexOf(photo), 1);
  buttons.get(photo)?.remove();
  buttons.delete(photo);
}

let wanted: Photo | undefined; // of several that are asked for while one is read, the last is opened
let opening: Promise<string>; // what went wrong

function openPhoto(photo: Photo): Promise<string> {
  if (!wanted) opening = openWanted(photo);
  else wanted = photo;
  return opening;
}

async function openWanted(photo: Photo): Promise<string> {
  let wrong = "";
  let opened: Photo | undefined;
  for (wanted = photo; wanted !== opened; ) {
    const next = (opened = wanted);
    wrong = await perform(`${next.name}: reading, and estimating depth …`, () => show(next));
  }
  wanted = undefined;
  return wrong;
}

async function show(photo: Photo): Promise<void> {
  try {
    const chosen = await call("open", photo.file, photo.depth, options(photo));
    current = photo;
    photo.wasOpened = true;
    $<HTMLFieldSetElement>("settings").disabled = $<HTMLFieldSetElement>("save").disabled = false;
    $<HTMLButtonElement>("show").disabled = false;
    view.classList.add("shown");
    fit.value = photo.fit;
    showChosen(chosen);
  } catch (error) {
    if (!photo.wasOpened && photo.depth instanceof File) {
      photo.depth = undefined; // perhaps only that is broken
      await show(photo);
    } else if (!photo.wasOpened) remove(photo);
    throw error;
  } finally {
    $("photos").hidden = photos.length < 2;
    for (const [one, button] of buttons) button.ariaCurrent = String(one === current);
    if (current) buttons.get(current)!.scrollIntoView({ block: "nearest", inline: "nearest" });
  }
}

function turnPage(step: number): void {
  const next = photos[photos.indexOf(wanted ?? current!) + step];
  if (next) void openPhoto(next);
}

// Settings

function options(of: Photo): Options {
  return { fit: of.fit as Options["fit"], method: method.value as Options["method"], ...of.byHand };
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
    if (current) showChosen(await call("set", options(current)));
  } catch (error) {
    tell(error);
  }
}

// Files: their names tell what they are, unless one is opened by the button of its kind.

const openers = {
  photo: {
    accept: "image/*",
    open: (files: File[]) => (files.length === 1 ? openPhotos([photoOf(files[0])]) : openAll(files)),
  },
  depth: { accept: "image/*", open: ([file]: File[]) => openDepth(file, current) },
  rgbd: {
    accept: "image/*",
    open: (files: File[]) => openPhotos(files.map((file) => photoOf(file, "right"))),
  },
  network: {
    accept: ".onnx",
    open: ([file]: File[]) => perform(`${file.name} …`, () => openNetwork(file)),
  },
  calibration: {
    accept: ".json",
    open: ([file]: File[]) => perform(`${file.name} …`, async () => calibrate(await file.text(), file.name)),
  },
};

async function openNetwork(file: File): Promise<void> {
  const { engine, chosen } = await call("openNetwork", file);
  $("network").hidden = false;
  $("network").textContent = `Depth by ${file.name}, on the ${engine}.`;
  showChosen(chosen);
}

function openDepth(file: File, photo?: Photo): Promise<string> {
  return perform(`${file.name} …`, async () => {
    if (!photo) throw new Error(`${file.name}: belongs to no photo that is open, expected the photo first`);
    const before = photo.depth;
    photo.depth = file;
    try {
      await show(photo);
    } catch (error) {
      photo.depth = before;
      throw error;
    }
  });
}

// Opens the first that can be read.
async function openPhotos(added: Photo[]): Promise<string> {
  const wrong: string[] = [];
  for (const photo of added) add(photo);
  for (const photo of added) {
    wrong.push(await openPhoto(photo));
    if (photos.includes(photo)) break;
  }
  return told(wrong);
}

async function openAll(files: File[]): Promise<string> {
  const wrong: string[] = [];
  const isKind = (file: File, ending: string) => file.name.toLowerCase().endsWith(ending);
  const pictures = files.filter((file) => !isKind(file, ".json") && !isKind(file, ".onnx"));
  for (const file of files.filter((one) => isKind(one, ".json"))) wrong.push(await openers.calibration.open([file]));
  for (const file of files.filter((one) => isKind(one, ".onnx"))) wrong.push(await openers.network.open([file]));
  const { photos: added, depths } = pairs(pictures, photos);
  wrong.push(await openPhotos(added));
  for (const [file, photo] of depths) wrong.push(await openDepth(file, photo ?? current));
  return told(wrong);
}

function told(wrong: string[]): string {
  const all = wrong.filter((one) => one !== "").join("\n");
  if (all) say(current?.name ?? "", all);
  return all;
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
    tell(error);
  }
  shown = wanted;
  isAsking = false;
}

function tick(milliseconds: number): void {
  if (swing.checked) position = Math.sin(milliseconds / 700);
  if (current && !isAsking && position !== shown && document.fullscreenElement !== panel) void drawView(position);
  requestAnimationFrame(tick);
}

function look(share: number): void {
  swing.checked = false;
  position = Math.max(-1, Math.min(1, 2 * share - 1));
}

// Tilting a phone or tablet. A swing that was asked for goes on until the tilt changes clearly.
let swingTilt: number | undefined;

function tilt({ beta, gamma }: DeviceOrientationEvent): void {
  if (beta === null || gamma === null) return; // of a computer
  $("tilt").hidden = true;
  const { angle } = screen.orientation;
  const degrees = angle === 90 ? beta : angle === 270 ? -beta : gamma;
  swingTilt ??= degrees;
  if (swing.checked && Math.abs(degrees - swingTilt) < 5) return;
  look(0.5 + degrees / 50);
}

// Safari asks whether a page may know the tilt, after a press of the user.
const orientation = globalThis.DeviceOrientationEvent as
  | { requestPermission?: () => Promise<PermissionState> }
  | undefined;

async function allowTilt(): Promise<void> {
  try {
    if ((await orientation!.requestPermission!()) !== "granted") throw new Error("is not allowed");
    $("tilt").hidden = true;
  } catch (error) {
    tell(new Error(`Tilt: ${(error as Error).message}, expected permission for motion and orientation`));
  }
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
  $("screen").textContent = $("misfit").textContent = fits
    ? ""
    : `The screen has ${columns} × ${rows} px, expected ${native.width} × ${native.height}: move this window to the ` +
      "display, set its scaling and the zoom of the page to 100 %, and press F there.";
}

interface DetailedScreen extends Screen {
  devicePixelRatio: number;
}

async function showOnDisplay(): Promise<void> {
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
    tell(new Error(`Full screen: ${(error as Error).message}`));
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
async function recordTurn(): Promise<void> {
  const seconds = 4;
  const canvas = document.createElement("canvas");
  draw(await call("view", 0, 960), canvas);
  const kind = MediaRecorder.isTypeSupported("video/webm") ? "webm" : "mp4"; // older versions of Safari
  const mimeType = `video/${kind}`;
  const recorder = new MediaRecorder(canvas.captureStream(30), { mimeType, videoBitsPerSecond: 12e6 });
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
  save(new Blob(parts, { type: mimeType }), `${stem()}.${kind}`);
}

const stem = () => stemOf(current!.name);
const png = { type: "image/png" };
const saves = {
  native: async () => save(new Blob([(await call("nativePng")) as BlobPart], png), `${stem()}-native.png`),
  quilt: async () => save(new Blob([(await call("quiltPng")) as BlobPart], png), await call("quiltName")),
  rgbd: async () => save(await pngOf(await call("rgbd")), `${stem()}_rgbd.png`),
  video: recordTurn,
};

// Events

document.addEventListener("click", ({ target }) => {
  const button = (target as HTMLElement).closest<HTMLElement>("[data-open], [data-save]");
  if (button?.dataset.save) {
    void perform("Saving …", saves[button.dataset.save as keyof typeof saves]);
  } else if (button?.dataset.open) {
    const opener = openers[button.dataset.open as keyof typeof openers];
    chooser.accept = opener.accept;
    chooser.multiple = button.dataset.open === "photo" || button.dataset.open === "rgbd";
    chooser.value = "";
    chooser.onchange = () => void opener.open([...chooser.files!]);
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
window.addEventListener("deviceorientation", tilt);
swing.addEventListener("change", () => (swingTilt = undefined));
$("tilt").hidden = !orientation?.requestPermission || navigator.maxTouchPoints === 0;
$("tilt").addEventListener("click", () => void allowTilt());
window.addEventListener("resize", () => {
  if (document.fullscreenElement === panel) fitPanel();
});
for (const slider of [strength, focus]) {
  slider.addEventListener("input", () => {
    if (current) current.byHand = { strength: strength.valueAsNumber, focus: focus.valueAsNumber };
    void apply();
  });
}
method.addEventListener("change", () => void apply());
fit.addEventListener("change", () => {
  if (current) current.fit = fit.value;
  void apply();
});
$("reset").addEventListener("click", () => {
  if (current) Object.assign(current, { byHand: undefined, fit: "auto" });
  fit.value = "auto";
  void apply();
});
sample.querySelector("optgroup")!.append(...sampleNames.map((name) => new Option(`${name} (sample)`, name)));
sample.addEventListener("change", () => {
  const { value } = sample;
  void perform("", () => calibrate(value ? sampleOf(value) : localStorage.getItem(kept.own)!, value || "visual.json"));
});
$("show").addEventListener("click", () => void showOnDisplay());
window.addEventListener("keydown", (event) => {
  const { key } = event;
  const isFull = document.fullscreenElement === panel;
  const target = event.target as HTMLElement;
  const isTaken = !isFull && target.matches(key === " " ? "button, input, select" : "[type=range], select");
  if (!current || isTaken || event.ctrlKey || event.metaKey || event.altKey) return;
  if (key.toLowerCase() === "f") void (isFull ? document.exitFullscreen() : showOnDisplay());
  else if (key === "PageDown" || (isFull && (key === "ArrowRight" || key === " "))) turnPage(1);
  else if (key === "PageUp" || (isFull && key === "ArrowLeft")) turnPage(-1);
  else if (key === " ") swing.click();
  else if (key === "ArrowLeft") look((position + 1) / 2 - 0.05);
  else if (key === "ArrowRight") look((position + 1) / 2 + 0.05);
  else return;
  event.preventDefault();
});

// Start

async function start(): Promise<void> {
  const { version, threads } = await call("start");
  const own = localStorage.getItem(kept.own);
  const chosen = localStorage.getItem(kept.sample);
  if (own) await calibrate(own, "stored calibration").catch(() => localStorage.removeItem(kept.own));
  if (!display || chosen) await calibrate(sampleOf(chosen && sampleNames.includes(chosen) ? chosen : sampleNames[0]), "sample");
  say(`Version ${version}${threads ? "" : ", on one thread"}`);
  document.body.dataset.ready = "true";
  requestAnimationFrame(tick);
}

void start().catch((error: Error) => say("", error.message));
void navigator.serviceWorker?.register("sw.js");
