// The library and the network of the page, in a thread of their own. Messages: see Calls.
import {
  type Altiro3D,
  type Chosen,
  type Depth,
  type Display,
  type DisplayFacts,
  estimate,
  load,
  type Options,
  ownNetwork,
  type Picture,
  type Profile,
  type Rendering,
  type Scene,
  storedDepth,
} from "altiro3d";
import * as ort from "onnxruntime-web/wasm";
import catalog from "../../../models/catalog.json";
import { readGreyPng } from "./png";

const mostPixels = 50e6; // of a photo; larger ones are shrunk when they are decoded
const depthFields = new Map(catalog.networks.map((one) => [one.file, one as object as Profile]));

let altiro3d: Altiro3D;
let display: Display | undefined;
let photo: ImageData | undefined;
let depth: Depth | undefined;
let scene: Scene | undefined;
let rendering: Rendering | undefined;
type Engine = typeof ort;
let network: { engine: Engine; session: ort.InferenceSession; profile: Profile } | undefined;
let options: Options = {};
let photoName = "";
let remarks: string[] = []; // on the photo
let isEstimated = false; // the depth, by the network

function replace<T extends { delete(): void }>(old: T | undefined, made: T): T {
  old?.delete();
  return made;
}

async function decode(file: Blob, name: string): Promise<ImageData> {
  let bitmap: ImageBitmap;
  try {
    bitmap = await createImageBitmap(file, { premultiplyAlpha: "none" });
  } catch {
    throw new Error(`${name}: is not a picture that this browser can read, expected JPEG, PNG or WebP`);
  }
  const factor = Math.min(1, Math.sqrt(mostPixels / (bitmap.width * bitmap.height)));
  const width = Math.max(1, Math.round(bitmap.width * factor));
  const height = Math.max(1, Math.round(bitmap.height * factor));
  const context = new OffscreenCanvas(width, height).getContext("2d", { alpha: false });
  if (!context) throw new Error(`${name}: is too large for this browser, expected fewer px`);
  context.drawImage(bitmap, 0, 0, width, height);
  bitmap.close();
  return context.getImageData(0, 0, width, height);
}

// A picture inside a file, as storedDepth() wants it.
async function decodePart(bytes: Uint8Array<ArrayBuffer>, numbers: boolean): Promise<Picture | Depth> {
  const grey = numbers ? await readGreyPng(bytes) : undefined;
  if (grey) return grey;
  const bitmap = await createImageBitmap(new Blob([bytes]), {
    imageOrientation: "none",
    premultiplyAlpha: "none",
    colorSpaceConversion: numbers ? "none" : "default",
  });
  const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d", { alpha: false })!;
  context.drawImage(bitmap, 0, 0);
  return context.getImageData(0, 0, bitmap.width, bitmap.height);
}

// The engine for WebGPU, which only networks that are dropped are worth: it has files of its own. It needs a
// graphics card (not a program that plays one), and that WebAssembly can wait for it.
async function gpuEngine(): Promise<Engine | undefined> {
  const { gpu } = navigator as { gpu?: { requestAdapter(): Promise<{ info: { isFallbackAdapter: boolean } } | null> } };
  const adapter = "Suspending" in WebAssembly ? await gpu?.requestAdapter() : undefined;
  const file = "./ort.jspi.min.mjs";
  return adapter && !adapter.info.isFallbackAdapter ? import(file) : undefined;
}

async function loadNetwork(model: Uint8Array, profile: Profile, engine: Engine, provider: string): Promise<void> {
  engine.env.wasm.wasmPaths = new URL("./", import.meta.url).href;
  engine.env.wasm.numThreads = globalThis.crossOriginIsolated ? Math.min(4, navigator.hardwareConcurrency) : 1;
  const session = await engine.InferenceSession.create(model, { executionProviders: [provider] });
  network = { engine, session, profile };
  estimates.clear();
}

const estimates = new Map<string, Depth>(); // by file, of this network

async function estimatedOnce(of: ImageData, file: File): Promise<Depth> {
  const key = `${file.name} ${file.size} ${file.lastModified}`;
  const known = estimates.get(key) ?? (await estimated(of));
  estimates.set(key, known);
  return known;
}

async function estimated(of: ImageData): Promise<Depth> {
  if (!network) {
    const model = await (await fetch("altiro3d-depth.onnx")).arrayBuffer();
    await loadNetwork(new Uint8Array(model), ownNetwork, ort, "wasm");
  }
  const { engine, session, profile } = network!;
  return estimate(altiro3d, of, profile, async ({ data, width, height }) => {
    const tensor = new engine.Tensor("float32", data, [1, 3, height, width]);
    const results = await session.run({ [session.inputNames[0]]: tensor });
    const output = results[session.outputNames[session.outputNames.length - 1]];
    const [rows, columns] = output.dims.slice(-2);
    return { data: (await output.getData()) as Float32Array, width: columns, height: rows };
  });
}

function render(): Chosen | undefined {
  if (!display || !scene) return undefined;
  rendering = replace(rendering, new altiro3d.Rendering(display, scene, options));
  return rendering.chosen();
}

function needRendering(): Rendering {
  if (!rendering) throw new Error("photo: is missing, expected one");
  return rendering;
}

// @param made throws before anything is lost
function setScene(
  newPhoto: ImageData,
  newDepth: Depth,
  made = new altiro3d.Scene(newPhoto, newDepth),
  said: string[] = [],
): Chosen | undefined {
  remarks = said;
  scene = replace(scene, made);
  photo = newPhoto;
  depth = newDepth;
  return render();
}

/** A picture with its depth at the right. */
function halves(whole: ImageData): [ImageData, Depth] {
  const half = whole.width >> 1;
  const left = new ImageData(half, whole.height);
  const right = new Uint8Array(half * whole.height);
  for (let y = 0; y < whole.height; ++y) {
    const row = 4 * y * whole.width;
    left.data.set(whole.data.subarray(row, row + 4 * half), 4 * y * half);
    for (let x = 0; x < half; ++x) right[y * half + x] = whole.data[row + 4 * (whole.width - half + x)];
  }
  return [left, { data: right, width: half, height: whole.height }];
}

async function depthOfFile(file: File): Promise<Depth> {
  const bytes = new Uint8Array(await file.arrayBuffer());
  const grey = await readGreyPng(bytes); // with all its bits, which a canvas does not keep
  if (grey) return grey;
  const { data, width, height } = await decode(file, file.name);
  return { data: data.filter((_, i) => i % 4 === 0), width, height };
}

const calls = {
  async start(): Promise<{ version: string; threads: boolean }> {
    altiro3d = await load();
    return { version: altiro3d.version(), threads: globalThis.crossOriginIsolated };
  },
  calibrate(text: string, name: string): DisplayFacts {
    display = replace(display, new altiro3d.Display(text, name));
    render();
    return display.facts;
  },
  /** @param depthFile depth of one's own; for a picture with its depth at the right, "right" */
  async open(file: File, depthFile: File | "right" | undefined, given: Options): Promise<Chosen | undefined> {
    let decoded = await decode(file, file.name);
    let own: Scene | undefined; // with depth or a pair that is in the file
    let said: string[] = [];
    let decodedDepth: Depth;
    if (depthFile === "right") [decoded, decodedDepth] = halves(decoded);
    else if (depthFile) decodedDepth = await depthOfFile(depthFile);
    else {
      const bytes = new Uint8Array(await file.arrayBuffer());
      const found = await storedDepth(altiro3d, bytes, file.name, decoded, decodePart);
      own = found.scene;
      said = own ? [found.text, ...found.remarks] : found.remarks;
      const left = own?.photo() ?? found.photo;
      if (left) decoded = new ImageData(left.data as Uint8ClampedArray<ArrayBuffer>, left.width, left.height);
      decodedDepth = own?.depth() ?? (await estimatedOnce(decoded, file));
    }
    options = given;
    const chosen = setScene(decoded, decodedDepth, own, said);
    photoName = file.name;
    isEstimated = !depthFile && !own;
    return chosen;
  },
  async openNetwork(file: File): Promise<{ engine: string; chosen?: Chosen }> {
    const profile = depthFields.get(file.name);
    if (!profile) {
      throw new Error(`${file.name}: is not known, expected ${[...depthFields.keys()].join(", ")}`);
    }
    const model = new Uint8Array(await file.arrayBuffer());
    const before = network;
    const use = async (engine: Engine, provider: string) => {
      await loadNetwork(model, profile, engine, provider);
      return { depth: photo && isEstimated ? await estimated(photo) : undefined };
    };
    const gpu = await gpuEngine().catch(() => undefined); // without network, it is only there after its first use
    const onGpu = gpu && (await use(gpu, "webgpu").catch(() => undefined));
    const { depth } =
      onGpu ??
      (await use(ort, "wasm").catch((error: unknown) => {
        network = before;
        throw new Error(`${file.name}: ${String(error).slice(0, 200)}, expected a whole ONNX file`);
      }));
    await before?.session.release();
    const chosen = photo && depth ? setScene(photo, depth) : undefined;
    return { engine: onGpu ? "graphics card" : "processor", chosen };
  },
  set(given: Options): Chosen | undefined {
    options = given;
    return render();
  },
  view: (position: number, height: number): Picture => needRendering().view(position, height),
  native: (): Picture => needRendering().native(),
  nativePng: (): Uint8Array => needRendering().nativePng(),
  quiltPng: (): Uint8Array => needRendering().quiltPng(),
  /** Where the depth of the photo comes from if it is not estimated, and what is unusual. */
  remarks: (): string[] => remarks,
  quiltName: (): string => needRendering().quiltName(photoName),
  /** Photo, and depth at its right, as near-white grey. */
  rgbd(): Picture {
    if (!photo || !depth) throw new Error("photo: is missing, expected one");
    const { width, height } = photo;
    let most = 0;
    for (const value of depth.data) most = Math.max(most, value);
    const data = new Uint8ClampedArray(8 * width * height).fill(255);
    for (let y = 0; y < height; ++y) {
      data.set(photo.data.subarray(4 * y * width, 4 * (y + 1) * width), 8 * y * width);
      const row = Math.floor(((y + 0.5) * depth.height) / height) * depth.width;
      for (let x = 0; x < width; ++x) {
        const value = (255 * depth.data[row + Math.floor(((x + 0.5) * depth.width) / width)]) / (most || 1);
        data.fill(value, 4 * (2 * y * width + width + x), 4 * (2 * y * width + width + x) + 3);
      }
    }
    return { data, width: 2 * width, height };
  },
};

export type Calls = typeof calls;

// One after the other, as they come.
let last: Promise<unknown> = Promise.resolve();
self.onmessage = ({ data: [id, name, args] }: MessageEvent<[number, keyof Calls, unknown[]]>) => {
  last = last.then(async () => {
    try {
      const result = await (calls[name] as (...args: unknown[]) => unknown)(...args);
      const data = (result as Partial<Picture> | undefined)?.data ?? result;
      const moved = data instanceof Uint8ClampedArray || data instanceof Uint8Array ? [data.buffer] : [];
      self.postMessage([id, result], { transfer: moved as Transferable[] });
    } catch (error) {
      self.postMessage([id, undefined, error instanceof Error ? error.message : String(error)]);
    }
  });
};
