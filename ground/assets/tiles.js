// The tiles below the map: Web Mercator, from the folder that the station was given.
// Source: OpenStreetMap wiki, Slippy map tilenames.

import { address, on, scene } from "./station.js";
import { radians } from "./canvas.js";

/** Width of a tile of zoom level 0 on the equator, m, with the metre of the map. */
const AROUND = 360 * 111_195;
/** Side of a tile, pixels. */
const SIDE = 256;
/** Largest number of tiles that are drawn at once, and that are kept. */
const [DRAWN, KEPT] = [64, 256];

/** Column and row of a position at a zoom level, as real numbers. */
export function tileAt(latitude, longitude, zoom) {
  const count = 2 ** zoom;
  return [count * (longitude + 180) / 360, count * (1 - Math.asinh(Math.tan(radians(latitude))) / Math.PI) / 2];
}

/** Latitude and longitude of the north-west corner of a tile. */
export function cornerOf(column, row, zoom) {
  const count = 2 ** zoom;
  return [Math.atan(Math.sinh(Math.PI * (1 - 2 * row / count))) * 180 / Math.PI, 360 * column / count - 180];
}

/** The images by name, the latest used last; `null` for a tile that the folder does not have. */
const images = new Map();
on("hello", () => images.clear());

/** The image of a tile, requested at the first call; `null` while it is not there. */
function image(zoom, column, row) {
  const name = `tiles/${zoom}/${column}/${row}`;
  let one = images.get(name);
  if (one === undefined) {
    one = new Image();
    one.onerror = () => images.set(name, null);
    one.src = address(name);
    if (images.size >= KEPT) images.delete(images.keys().next().value);
  } else images.delete(name);
  images.set(name, one);
  return one?.complete && one.naturalWidth ? one : null;
}

/** Draws a tile, or the part of a coarser tile while it is missing. */
function draw(context, [zoom, column, row], place) {
  const [left, top] = place(cornerOf(column, row, zoom));
  const [right, bottom] = place(cornerOf(column + 1, row + 1, zoom));
  for (const coarse of scene.zooms.filter((one) => one <= zoom).reverse()) {
    const parts = 2 ** (zoom - coarse);
    const found = image(coarse, Math.floor(column / parts), Math.floor(row / parts));
    if (!found) continue;
    const [width, height] = [found.naturalWidth / parts, found.naturalHeight / parts];
    // A pixel of overlap hides the seams.
    context.drawImage(found, (column % parts) * width, (row % parts) * height, width, height, left, top, right - left + 1, bottom - top + 1);
    return true;
  }
  return false;
}

/**
 * Draws the tiles of an area. `place` gives the pixels of a latitude and longitude, `scale` is pixels per metre.
 * Returns whether there was one.
 */
export function tiles(context, [north, west], [south, east], scale, place) {
  const metres = AROUND * Math.cos(radians((north + south) / 2));
  const wanted = Math.log2(metres * scale / SIDE * (devicePixelRatio || 1));
  const reach = (zoom) => [tileAt(north, west, zoom), tileAt(south, east, zoom)].map((corner) => corner.map(Math.floor));
  const fits = (zoom) => {
    const [[left, top], [right, bottom]] = reach(zoom);
    return (right - left + 1) * (bottom - top + 1) <= DRAWN;
  };
  // The coarsest level that is fine enough, else the finest one that there is.
  const fitting = scene.zooms.filter(fits);
  const zoom = fitting.find((one) => one >= wanted - 0.25) ?? fitting.at(-1);
  if (zoom === undefined) return false;
  const [[left, top], [right, bottom]] = reach(zoom);
  let any = false;
  for (let column = left; column <= right; column += 1) {
    for (let row = top; row <= bottom; row += 1) any = draw(context, [zoom, column, row], place) || any;
  }
  return any;
}
