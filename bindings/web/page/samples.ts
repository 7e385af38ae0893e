// Sample calibrations: numbers of the models as their maker publishes them, or usual ones. No lens lies exactly so.

const cells = [
  [-0.31, 0.25, 0.28, 0.25, 0, -0.25],
  [-0.31, -0.25, 0.28, -0.25, 0, 0.25],
];
const turned = [
  [-0.25, -0.31, -0.25, 0.28, 0.25, 0],
  [0.25, -0.31, 0.25, 0.28, -0.25, 0],
];

type Sample = [serial: string, width: number, height: number, DPI: number, viewCone: number, pitch: number,
               slope: number, CellPatternMode?: number, cells?: number[][]];

/** By the names that the library gives the models. */
const samples: Record<string, Sample> = {
  "Looking Glass Portrait": ["P", 1536, 2048, 324, 40, 52.58, -7.17],
  "Looking Glass Go": ["E", 1440, 2560, 491, 54, 80.75, -6.66],
  'Looking Glass 16" landscape': ["J", 3840, 2160, 283, 50, 44.75, -6.87, 2, cells],
  'Looking Glass 16" portrait': ["H", 2160, 3840, 283, 50, 44.72, -7.45, 4, turned],
  'Looking Glass 32" landscape': ["L", 7680, 4320, 280, 50, 75, -7.2],
  'Looking Glass 32" portrait': ["K", 4320, 7680, 280, 54, 80.7, -6.3, 2, cells],
  'Looking Glass 65"': ["D", 7680, 4320, 136, 40, 42, -6],
  'Looking Glass 16" (2nd generation)': ["A", 3840, 2160, 283, 40, 50.07, -7],
  'Looking Glass 32" (2nd generation)': ["B", 7680, 4320, 280, 40, 42, -6],
  'Looking Glass 8.9"': ["2K", 2560, 1600, 338, 40, 49.8, -5.45],
  'Looking Glass 15.6"': ["4K", 3840, 2160, 283, 40, 50.07, -7.7],
  "Looking Glass 8K": ["8K", 7680, 4320, 280, 40, 38.05, -7.7],
};

export const sampleNames = Object.keys(samples);

/** Serial numbers of samples end so. */
export const sampleEnding = "-SAMPLE";

/** The text of a visual.json. */
export function sampleOf(name: string): string {
  const [serial, screenW, screenH, DPI, viewCone, pitch, slope, CellPatternMode, offsets] = samples[name];
  const numbers = { pitch, slope, center: 0.5, viewCone, invView: 1, DPI, screenW, screenH, CellPatternMode };
  const values = Object.entries(numbers).filter(([, value]) => value !== undefined);
  return JSON.stringify({
    configVersion: "1.0",
    serial: `LKG-${serial}${sampleEnding}`,
    ...Object.fromEntries(values.map(([key, value]) => [key, { value }])),
    subpixelCells: offsets?.map(([rx, ry, gx, gy, bx, by]) => ({
      ROffsetX: rx, ROffsetY: ry, GOffsetX: gx, GOffsetY: gy, BOffsetX: bx, BOffsetY: by,
    })),
  });
}
