// The photos that are open, and the strip of their thumbnails.

export interface Photo {
  name: string;
  file: File;
  depth?: File | "right"; // of one's own; "right": in the right half of the picture
  wasOpened?: boolean;
  fit: string;
  /** Chosen by hand; otherwise they follow from the picture. */
  byHand?: { strength: number; focus: number };
}

export const photoOf = (file: File, depth?: "right"): Photo => ({ name: file.name, file, depth, fit: "auto" });
export const stemOf = (name: string) => name.replace(/\.\w+$/, "");

const depthEnding = /[-_.]depth$/i;

/** Photos among files, each with the depth that lies beside it, and depths without a photo. */
export function pairs(files: File[], already: Photo[]): { photos: Photo[]; depths: [File, Photo?][] } {
  const isDepth = (file: File) => depthEnding.test(stemOf(file.name));
  const photos = files
    .filter((file) => !isDepth(file))
    .map((file) => photoOf(file, /rgbd$/i.test(stemOf(file.name)) ? "right" : undefined));
  const depths: [File, Photo?][] = [];
  for (const file of files.filter(isDepth)) {
    const stem = stemOf(file.name).replace(depthEnding, "").toLowerCase();
    const isIts = (photo: Photo) => stemOf(photo.name).toLowerCase() === stem;
    const added = photos.find(isIts);
    if (added) added.depth = file;
    else depths.push([file, already.find(isIts)]);
  }
  return { photos, depths };
}

/** A button with a small picture; `open` is called when it is pressed. */
export function thumbnailOf(photo: Photo, open: () => void): HTMLButtonElement {
  const button = document.createElement("button");
  button.type = "button";
  button.title = button.textContent = photo.name;
  button.addEventListener("click", open);
  last = last.then(() => drawThumbnail(photo, button)).catch(() => {}); // a broken photo keeps its name
  return button;
}

let last = Promise.resolve(); // one after the other, as a decoded photo is large

async function drawThumbnail(photo: Photo, button: HTMLButtonElement): Promise<void> {
  const height = 128;
  const bitmap = await createImageBitmap(photo.file, { resizeHeight: height, resizeQuality: "medium" });
  const canvas = document.createElement("canvas");
  canvas.width = photo.depth === "right" ? bitmap.width >> 1 : bitmap.width;
  canvas.height = height;
  canvas.getContext("2d")!.drawImage(bitmap, 0, 0);
  bitmap.close();
  button.ariaLabel = photo.name;
  button.replaceChildren(canvas);
}
