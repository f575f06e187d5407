/**
 * Marks of burnt-out and black pixels over the server's pictures. Live frames are marked by
 * live/material.js, in the same colours and widths.
 */

/** Colours of the stripes along a diagonal, and their width. The picture shows through null. */
const BURNT = ["#ff00b3", "#000000", null, null];
const BLACK = ["#338cff", null, null, null];
const STRIPE_PX = 2;

/**
 * Finds the pixels to mark.
 * @param {Uint8ClampedArray} pixels four codes each, sRGB and coverage
 * @returns {{burnt: Uint8ClampedArray, black: Uint8ClampedArray}} as opaque and transparent
 *   pixels
 */
export function marked(pixels) {
  const burnt = new Uint8ClampedArray(pixels.length);
  const black = new Uint8ClampedArray(pixels.length);
  for (let at = 0; at < pixels.length; at += 4) {
    // Edge pixels are mixed with the background and do not count.
    if (pixels[at + 3] < 255) continue;
    const strongest = Math.max(pixels[at], pixels[at + 1], pixels[at + 2]);
    if (strongest === 255) burnt[at + 3] = 255;
    if (strongest === 0) black[at + 3] = 255;
  }
  return { burnt, black };
}

/** Context of a square canvas that is not on the page. @param {number} side */
function sheet(side) {
  const context = new OffscreenCanvas(side, side).getContext("2d");
  if (!context) throw new Error("this browser has no 2D canvas");
  return context;
}

/** Diagonal stripes of whole pixels. @param {(string|null)[]} colors */
function stripes(colors) {
  const side = colors.length * STRIPE_PX;
  const tile = sheet(side);
  for (let y = 0; y < side; y += 1) {
    for (let x = 0; x < side; x += 1) {
      const color = colors[Math.floor(((x + y) % side) / STRIPE_PX)];
      if (!color) continue;
      tile.fillStyle = color;
      tile.fillRect(x, y, 1, 1);
    }
  }
  return tile.canvas;
}

/**
 * Draws stripes where a mask is opaque, with the mask scaled to the canvas.
 * @param {CanvasRenderingContext2D} onto
 * @param {Uint8ClampedArray} mask
 * @param {number} side of the mask
 * @param {(string|null)[]} colors
 */
function stamp(onto, mask, side, colors) {
  const small = sheet(side);
  small.putImageData(new ImageData(new Uint8ClampedArray(mask), side, side), 0, 0);
  const whole = onto.canvas.width;
  const shape = sheet(whole);
  shape.imageSmoothingEnabled = whole < side;
  shape.drawImage(small.canvas, 0, 0, whole, whole);
  shape.globalCompositeOperation = "source-in";
  shape.fillStyle = shape.createPattern(stripes(colors), "repeat") ?? "transparent";
  shape.fillRect(0, 0, whole, whole);
  onto.drawImage(shape.canvas, 0, 0);
}

/**
 * Draws the marks of a picture at the canvas' size on the screen; nothing if the picture cannot be
 * read.
 * @param {HTMLCanvasElement} canvas
 * @param {string} url
 */
export async function mark(canvas, url) {
  const image = new Image();
  image.src = url;
  try {
    await image.decode();
  } catch {
    return;
  }
  if (!canvas.isConnected) return;
  const side = image.naturalWidth;
  const reading = sheet(side);
  reading.drawImage(image, 0, 0);
  const { burnt, black } = marked(reading.getImageData(0, 0, side, side).data);
  canvas.width = canvas.height = Math.max(1, Math.round(canvas.clientWidth * devicePixelRatio));
  const context = canvas.getContext("2d");
  if (!context) return;
  stamp(context, burnt, side, BURNT);
  stamp(context, black, side, BLACK);
}
