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
import { readGreyPng } from "./png";

const mostPixels = 50e6; // of a photo; larger ones are shrunk when they are decoded
const depthFields = new Map<string, Profile>([
  ["altiro3d-depth.onnx", ownNetwork],
  ["model-small.onnx", { inputWidth: 256, inputHeight: 256 }],
  [
    "depth-anything-v2-small.onnx",
    {
      inputWidth: 518,
      inputHeight: 518,
      multipleOf: 14,
      inputShape: "photo",
      mean: [0.485, 0.456, 0.406],
      std: [0.229, 0.224, 0.225],
    },
  ],
]);

let altiro3d: Altiro3D;
let display: Display | undefined;
let photo: ImageData | undefined;
let depth: Depth | undefined;
let scene: Scene | undefined;
let rendering: Rendering | undefined;
let network: { session: ort.InferenceSession; profile: Profile } | undefined;
let options: Options = {};
let photoName = "";
let remarks: string[] = []; // on the photo

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

async function loadNetwork(model: string | ArrayBuffer, profile: Profile): Promise<void> {
  ort.env.wasm.wasmPaths = new URL("./", import.meta.url).href;
  ort.env.wasm.numThreads = globalThis.crossOriginIsolated ? Math.min(4, navigator.hardwareConcurrency) : 1;
  const session =
    typeof model === "string"
      ? await ort.InferenceSession.create(model)
      : await ort.InferenceSession.create(model);
  await network?.session.release();
  network = { session, profile };
}

async function estimated(of: ImageData): Promise<Depth> {
  if (!network) await loadNetwork("altiro3d-depth.onnx", ownNetwork);
  const { session, profile } = network!;
  return estimate(altiro3d, of, profile, async ({ data, width, height }) => {
    const tensor = new ort.Tensor("float32", data, [1, 3, height, width]);
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
  async open(file: File): Promise<Chosen | undefined> {
    let decoded = await decode(file, file.name);
    const bytes = new Uint8Array(await file.arrayBuffer());
    const found = await storedDepth(altiro3d, bytes, file.name, decoded, decodePart);
    const { scene } = found;
    const own = scene?.photo() ?? found.photo;
    if (own) decoded = new ImageData(own.data as Uint8ClampedArray<ArrayBuffer>, own.width, own.height);
    const said = scene ? [found.text, ...found.remarks] : found.remarks;
    const chosen = setScene(decoded, scene?.depth() ?? (await estimated(decoded)), scene, said);
    photoName = file.name;
    return chosen;
  },
  /** A picture with its depth at the right. */
  async openRgbd(file: File): Promise<Chosen | undefined> {
    const whole = await decode(file, file.name);
    const half = whole.width >> 1;
    const left = new ImageData(half, whole.height);
    const right = new Uint8Array(half * whole.height);
    for (let y = 0; y < whole.height; ++y) {
      const row = 4 * y * whole.width;
      left.data.set(whole.data.subarray(row, row + 4 * half), 4 * y * half);
      for (let x = 0; x < half; ++x) right[y * half + x] = whole.data[row + 4 * (whole.width - half + x)];
    }
    const chosen = setScene(left, { data: right, width: half, height: whole.height });
    photoName = file.name;
    return chosen;
  },
  async openDepth(file: File): Promise<Chosen | undefined> {
    if (!photo) throw new Error(`${file.name}: needs a photo, expected to be opened after it`);
    return setScene(photo, await depthOfFile(file));
  },
  async openNetwork(file: File): Promise<Chosen | undefined> {
    const profile = depthFields.get(file.name);
    if (!profile) {
      throw new Error(`${file.name}: is not known, expected ${[...depthFields.keys()].join(", ")}`);
    }
    await loadNetwork(await file.arrayBuffer(), profile).catch((error: unknown) => {
      throw new Error(`${file.name}: ${String(error).slice(0, 200)}, expected a whole ONNX file`);
    });
    return photo && setScene(photo, await estimated(photo));
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
