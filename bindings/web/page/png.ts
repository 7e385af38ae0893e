// Grey PNG files of 8 or 16 bits, as depth images are. A canvas would keep 8 bits.
import type { Depth } from "altiro3d";

/** The values of a grey PNG without alpha or interlacing; undefined for any other file. */
export async function readGreyPng(file: Uint8Array): Promise<Depth | undefined> {
  const view = new DataView(file.buffer, file.byteOffset, file.byteLength);
  if (file.length < 33 || view.getUint32(0) !== 0x89504e47 || view.getUint32(12) !== 0x49484452) return undefined;
  const [width, height] = [view.getUint32(16), view.getUint32(20)];
  const bytes = file[24] / 8;
  const isGrey = (bytes === 1 || bytes === 2) && file[25] === 0 && file[28] === 0;
  if (!isGrey || width === 0 || height === 0 || width * height > 1 << 28) return undefined;
  const parts: BlobPart[] = [];
  for (let at = 8; at + 12 <= file.length; ) {
    const length = view.getUint32(at);
    if (view.getUint32(at + 4) === 0x49444154) parts.push(file.slice(at + 8, at + 8 + length));
    at += 12 + length;
  }
  let rows: Uint8Array;
  try {
    const stream = new Blob(parts).stream().pipeThrough(new DecompressionStream("deflate"));
    rows = new Uint8Array(await new Response(stream).arrayBuffer());
  } catch {
    return undefined;
  }
  const stride = width * bytes;
  if (rows.length < height * (stride + 1)) return undefined;
  const data = bytes === 2 ? new Uint16Array(width * height) : new Uint8Array(width * height);
  const now = new Uint8Array(stride);
  const above = new Uint8Array(stride);
  for (let y = 0; y < height; ++y) {
    const start = y * (stride + 1);
    for (let x = 0; x < stride; ++x) {
      const a = x >= bytes ? now[x - bytes] : 0;
      const b = above[x];
      const c = x >= bytes ? above[x - bytes] : 0;
      now[x] = rows[start + 1 + x] + predicted(rows[start], a, b, c);
    }
    for (let x = 0; x < width; ++x)
      data[y * width + x] = bytes === 2 ? (now[2 * x] << 8) | now[2 * x + 1] : now[x];
    above.set(now);
  }
  return { data, width, height };
}

function predicted(filter: number, left: number, up: number, corner: number): number {
  if (filter === 1) return left;
  if (filter === 2) return up;
  if (filter === 3) return (left + up) >> 1;
  if (filter !== 4) return 0;
  const [a, b, c] = [up - corner, left - corner, left + up - 2 * corner].map(Math.abs);
  return a <= b && a <= c ? left : b <= c ? up : corner;
}
