/**
 * altiro3D in a browser or a worker: photos with depth become pictures for light-field displays.
 *
 *     const altiro3d = await load();
 *     const display = new altiro3d.Display(await (await fetch("visual.json")).text(), "visual.json");
 *     const scene = new altiro3d.Scene(imageData, { data: floats, width: 640, height: 480 });
 *     const rendering = new altiro3d.Rendering(display, scene, { method: "layered" });
 *     const native = rendering.native(); // { data, width, height } of the panel
 *     rendering.delete();
 *
 * What is wrong is thrown as an Error of one sentence. Objects hold memory that JavaScript does not
 * see: call delete() when you no longer need them. Pictures are ordinary arrays.
 */

/** Rows from the top, RGBA; as ImageData. A photo's alpha is ignored. */
export interface Picture {
  data: Uint8ClampedArray;
  width: number;
  height: number;
}

/** Depth of a whole photo, of any size. */
export interface Depth {
  data: Float32Array | Uint16Array | Uint8Array | Uint8ClampedArray;
  width: number;
  height: number;
  /** near-white (default): larger is nearer; far-white: larger is farther; metric: distances. */
  kind?: "near-white" | "far-white" | "metric";
  /** Whether it comes from Estimate, so that its edges are those of the photo. */
  estimated?: boolean;
}

export interface DisplayFacts {
  serial: string;
  /** "Looking Glass Portrait"; empty if it is unknown. */
  model: string;
  /** Of the panel, px. */
  width: number;
  height: number;
  /** Of the panel, width : height. */
  aspect: number;
  /** Number of views of a quilt. */
  views: number;
  /** What is unusual about the calibration. */
  remarks: string[];
}

/** What is not given is chosen as photo2native does. */
export interface Options {
  method?: "fast" | "real" | "layered";
  /** Parallax between the outermost views, % of the width. */
  strength?: number | "auto";
  /** Depth that lies on the panel's surface, 0 (farthest) to 1. */
  focus?: number | "auto";
  fit?: "cover" | "contain" | "stretch" | "auto";
  zoom?: number;
  /** Exponent of depth, 0.5 to 2. */
  depthCurve?: number;
  /** Leaves the edges of the depth where they are. */
  exactDepth?: boolean;
  /** Detail that is kept: view (as published, quick) or lens (default). Real has view only. */
  detail?: "view" | "lens";
}

export interface Chosen {
  strength: number;
  focus: number;
  zoom: number;
  centreX: number;
  centreY: number;
}

/** How a network reads photos; the fields of models/catalog.json. */
export interface Profile {
  inputWidth: number;
  inputHeight: number;
  multipleOf?: number;
  inputShape?: "fixed" | "photo";
  channelOrder?: "RGB" | "BGR";
  scale?: number;
  mean?: [number, number, number];
  std?: [number, number, number];
  resizeKernel?: "nearest" | "linear" | "cubic" | "area";
  output?: "inverseDepth" | "metricDepth";
}

interface Owned {
  delete(): void;
}

/** A display, from the text of its visual.json. */
export interface Display extends Owned {
  readonly facts: DisplayFacts;
}

/** A photo and its depth. */
export interface Scene extends Owned {
  photo(): Picture;
  /** From 0, the farthest, to 1. */
  depth(): Depth;
}

/** Depth that came with a photo, or follows from the pictures of both eyes. */
export interface Found {
  /** Its photo is the left eye's picture. */
  scene?: Scene;
  /** Without a scene: the left eye's picture, if the eyes do not match. */
  photo?: Picture;
  /** Where the depth comes from. */
  text: string;
  /** What is unusual, or not used. */
  remarks: string[];
}

/** How a picture holds the pictures of both eyes. */
export interface Halves {
  layout?: "left-right" | "right-left" | "top-bottom" | "bottom-top";
  /** Default: squeezed if the picture is about 16 : 9. */
  halves?: "full" | "squeezed";
}

/** The file of a photo, with what it holds besides the picture that browsers show: see storedDepth(). */
export interface StoredDepth extends Owned {
  /** A JPEG or PNG; empty without one. */
  depthPicture(): Uint8Array;
  /** A JPEG or PNG with the right eye's picture (MPO); empty without one. */
  secondEye(): Uint8Array;
  /** @param depth, eye those pictures, decoded and not turned */
  scene(photo: Picture, depth?: Picture | Depth, eye?: Picture): Found;
}

/** A scene on a display. */
export interface Rendering extends Owned {
  /** What the panel shows. */
  native(): Picture;
  /** A PNG file that is marked as a Native. */
  nativePng(): Uint8Array;
  quilt(): Picture;
  quiltPng(): Uint8Array;
  /** The file name of the quilt of a photo: "photo_qs8x6a0.75.png". */
  quiltName(photo: string): string;
  /** One view, in the panel's shape: position -1 (leftmost camera) to 1, height in px. */
  view(position: number, height: number): Picture;
  chosen(): Chosen;
}

/** The depth of a photo by a network that the caller runs: see estimate(). */
export interface Estimate extends Owned {
  runs(): number;
  /** What the network reads in a run: planes of rows x columns. */
  input(run: number): { data: Float32Array; width: number; height: number };
  setOutput(run: number, output: { data: Float32Array; width: number; height: number }): void;
  /** The depth, after all runs. */
  depth(): Depth;
}

export interface Altiro3D {
  Display: new (calibration: string, name: string) => Display;
  Scene: new (photo: Picture, depth: Depth) => Scene;
  Rendering: new (display: Display, scene: Scene, options: Options) => Rendering;
  Estimate: new (photo: Picture, profile: Profile) => Estimate;
  StoredDepth: new (file: Uint8Array, name: string) => StoredDepth;
  /** Depth of a stereo pair, by matching. */
  matchEyes(left: Picture, right: Picture): Found;
  /** Takes a picture of both eyes apart. */
  splitEyes(picture: Picture, how: Halves): { left: Picture; right: Picture };
  version(): string;
  setThreads(threads: number): void;
  /** Bytes of the module's memory that are in use. */
  memoryInUse(): number;
}

/**
 * Loads the module. With threads, call it in a worker: a page must not wait for threads.
 * @param threads default: those of the processor, at most 4; 1 where the page is not isolated
 *        (crossOriginIsolated), which threads need
 */
export async function load(threads = navigator.hardwareConcurrency): Promise<Altiro3D> {
  const most = Math.min(threads, globalThis.crossOriginIsolated ? 4 : 1);
  const { default: make } = await (most > 1
    ? import("./altiro3d-threads.js")
    : import("./altiro3d.js"));
  const altiro3d = (await make()) as Altiro3D;
  altiro3d.setThreads(most);
  return altiro3d;
}

/** The profile of altiro3d-depth.onnx, our own network. */
export const ownNetwork: Profile = {
  inputWidth: 256,
  inputHeight: 256,
  multipleOf: 32,
  inputShape: "photo",
  mean: [0.5, 0.5, 0.5],
  std: [0.5, 0.5, 0.5],
  resizeKernel: "area",
};

/**
 * Estimates the depth of a photo.
 * @param run runs the network: takes a tensor [1, 3, height, width] and returns the values and the
 *        size of its output
 */
export async function estimate(
  altiro3d: Altiro3D,
  photo: Picture,
  profile: Profile,
  run: (input: { data: Float32Array; width: number; height: number }) => Promise<{
    data: Float32Array;
    width: number;
    height: number;
  }>,
): Promise<Depth> {
  const estimate = new altiro3d.Estimate(photo, profile);
  try {
    for (let i = 0; i < estimate.runs(); ++i) estimate.setOutput(i, await run(estimate.input(i)));
    return estimate.depth();
  } finally {
    estimate.delete();
  }
}

/**
 * Reads depth that comes with a photo, as photo2native does: depth that a phone has stored in its JPEG; or
 * matches both eyes: those of an MPO or JPS file, or of a picture that says so by its name ("beach_LR.jpg").
 *
 * @param photo the file, decoded and upright
 * @param decode decodes a JPEG or PNG inside the file without turning it; numbers: not into other colours
 *        either, and with all bits
 * @returns without scene if the depth must be estimated
 */
export async function storedDepth(
  altiro3d: Altiro3D,
  file: Uint8Array,
  name: string,
  photo: Picture,
  decode: (file: Uint8Array<ArrayBuffer>, numbers: boolean) => Promise<Picture | Depth>,
): Promise<Found> {
  const stored = new altiro3d.StoredDepth(file, name);
  const decoded = (part: Uint8Array, numbers: boolean) =>
    part.length > 0 ? decode(part as Uint8Array<ArrayBuffer>, numbers).catch(() => undefined) : undefined;
  try {
    const depth = await decoded(stored.depthPicture(), true);
    const eye = (await decoded(stored.secondEye(), false)) as Picture | undefined;
    return stored.scene(photo, depth, eye);
  } finally {
    stored.delete();
  }
}
