// What Emscripten makes.
declare module "*/altiro3d.js" {
  export default function make(): Promise<unknown>;
}
declare module "*/altiro3d-threads.js" {
  export default function make(): Promise<unknown>;
}
