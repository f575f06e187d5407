/**
 * The one canvas over the frames: its size, the squares of the frames in it, and its context.
 *
 * @import { Cell } from "../model.js"
 */

/** Largest side of the canvas in pixels; more costs time without a visible gain. */
const LIMIT_PX = 2048;
/** Number of shaders to compile at a time where the driver compiles in parallel. */
const TOGETHER = 4;
/** Space between a frame's border and its picture in CSS pixels, as in stage.css. */
const INSET_PX = 3;

/**
 * @typedef {{cell: Cell, corner: [number, number]}} Square `corner`: lower left, pixels
 *
 * @typedef {{width: number, height: number, css: {left: string, top: string, width: string,
 *   height: string}, small: number, large: number, squares: Square[]}} Layout `width`, `height`: of
 *   the drawing buffer; `small`, `large`: side of a frame and of the centre in it; `css` aligns the
 *   canvas with the pixels of the screen, so that nothing is blurred.
 */

/**
 * Computes the squares of all frames in a drawing buffer whose resolution is `ratio` times the
 * screen's.
 * @param {HTMLCanvasElement} canvas
 * @param {number} ratio
 * @param {number} most largest side of a frame in pixels
 * @returns {Layout|null} null if nothing is visible
 */
export function layOut(canvas, ratio, most) {
  const frames = canvas.parentElement;
  const whole = frames?.getBoundingClientRect();
  if (!frames || !whole || whole.width < 1 || whole.height < 1) return null;
  // The large frame takes two thirds of the side.
  const limit = Math.min(LIMIT_PX, 1.5 * most);
  const fine = Math.min(devicePixelRatio, limit / Math.max(whole.width, whole.height)) * ratio;
  const width = Math.max(1, Math.round(whole.width * fine));
  const height = Math.max(1, Math.round(whole.height * fine));
  /** @param {number} at */
  const snapped = (at) => Math.round(at * devicePixelRatio) / devicePixelRatio;
  const [left, top] = [snapped(whole.left), snapped(whole.top)];
  /** @type {Square[]} */
  const squares = [];
  let small = Number.POSITIVE_INFINITY;
  let large = 1;
  for (const frame of /** @type {NodeListOf<HTMLElement>} */ (
    frames.querySelectorAll("[data-cell]")
  )) {
    const { cell: name } = frame.dataset;
    const rect = frame.getBoundingClientRect();
    const side = Math.max(1, Math.floor((Math.min(rect.width, rect.height) - 2 * INSET_PX) * fine));
    if (name === "centre") large = side;
    else small = Math.min(small, side);
    const x = Math.round((rect.left + INSET_PX - left) * fine);
    const y = height - Math.round((rect.top + INSET_PX - top) * fine) - side;
    squares.push({
      cell: name === "centre" ? "centre" : Number(name),
      corner: [Math.max(0, x), Math.max(0, y)],
    });
  }
  if (squares.length === 0) return null;
  const css = {
    left: `${left - whole.left}px`,
    top: `${top - whole.top}px`,
    width: `${width / fine}px`,
    height: `${height / fine}px`,
  };
  return { width, height, css, small, large, squares };
}

/**
 * Observes an element's size in pixels of the screen, which also changes with the screen; in CSS
 * pixels where the browser does not support that.
 * @param {ResizeObserver} observer
 * @param {Element} element
 */
export function observePixels(observer, element) {
  try {
    observer.observe(element, { box: "device-pixel-content-box" });
  } catch {
    observer.observe(element);
  }
}

/**
 * @typedef {{gl: WebGL2RenderingContext, software: boolean, together: number, renderer:
 *   string}} Context `together`: number of shaders to compile at a time.
 */

/**
 * True if pixels are read back exactly. Browsers that resist fingerprinting return noise, which
 * would falsify measured exposures.
 * @param {WebGL2RenderingContext} gl
 */
function readsBackExactly(gl) {
  const [texture, framebuffer] = [gl.createTexture(), gl.createFramebuffer()];
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32F, 1, 1);
  gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, 0);
  const drawn = [0.25, 0.5, 0.75, 1];
  gl.clearBufferfv(gl.COLOR, 0, drawn);
  const read = new Float32Array(4);
  gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.FLOAT, read);
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  gl.deleteFramebuffer(framebuffer);
  gl.deleteTexture(texture);
  return drawn.every((value, k) => read[k] === value);
}

/**
 * Opens the context of a canvas; null if the browser does not support what drawing needs.
 * @param {HTMLCanvasElement} canvas
 * @returns {Context|null}
 */
export function openContext(canvas) {
  const gl = canvas.getContext("webgl2", {
    alpha: true,
    premultipliedAlpha: true,
    antialias: false,
    depth: false,
    stencil: false,
  });
  if (!gl || !gl.getExtension("EXT_color_buffer_float")) return null;
  const parallel = gl.getExtension("KHR_parallel_shader_compile") !== null;
  if (!readsBackExactly(gl)) return null;
  const info = gl.getExtension("WEBGL_debug_renderer_info");
  const renderer = String(gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
  const software = /swiftshader|llvmpipe|softpipe|software|basic render/i.test(renderer);
  // A software renderer compiles on the cores that draw, and parallel compilation would block the
  // page.
  return { gl, renderer, software, together: parallel && !software ? TOGETHER : 1 };
}
