/**
 * Cache of compiled materials by genome hash. Fetches their code and their lit spheres, and
 * compiles a few at a time.
 *
 * @import { Individual } from "../model.js"
 * @import { Look, Material, Meter } from "./material.js"
 * @import { Environment } from "./spheres.js"
 * @import { SurfacePrograms } from "./surface.js"
 */
import { getText, problemOf } from "../api/request.js";
import { sceneStore } from "../scene/store.js";
import {
  METER_ANGLES, advance, dropMaterial, environmentOf, isStyle, makeMaterial, remeter, replaceSpheres,
} from "./material.js";
import { indexOf } from "./paint.js";
import { getSpheres, makeSpheres } from "./spheres.js";

/** Number of materials kept: three broods, so that going back and forth compiles nothing. */
const KEPT = 64;
/** Requests at a time; browsers allow six connections to a server, and pictures come first. */
const FETCHES = 2;
/** Delay before a request is repeated that the server could not answer. */
const AGAIN_MS = 5000;

/**
 * @typedef {{source: string|null, isClear: boolean, within: number, lights: number, file:
 *   ArrayBuffer|null, environment: string, material: Material|null, fetching: boolean, failed:
 *   boolean, hasFailed: boolean, refused: boolean, used: number}}
 *   Entry `source`: GLSL; `isClear`: true if it is of a clear material; `within`, `lights`: bound
 *   on the texture coordinates, and number of lights of painted materials, for which it was
 *   generated; `file`: lit spheres in the environments of the key `environment`, which the material
 *   may not have yet; `failed`: the server refused the request or could not be reached a moment
 *   ago; `hasFailed`: nothing has come since; `refused`: the server refused the request; `used`:
 *   time of the last use, in calls of `work`.
 *
 * @typedef {{meter: Meter, look: Look, pens: SurfacePrograms, within: number, environment:
 *   Environment, together: number, painting: number, clearing: boolean}}
 *   Making `look`: where exposure is measured; `within`: bound on the object's texture coordinates;
 *   `together`: number of shaders compiled at a time; `painting`: number of lights of painted
 *   materials, 0 if these cannot be drawn; `clearing`: true if clear ones can be
 *
 * @typedef {Pick<Individual, "id"|"hash">} Source What the code of a material is requested for
 */

/** Path of the code of an individual, without a query. @param {Source} of */
const ofIndividual = ({ id }) => `/v1/individuals/${id}/exports/glsl-es-300?`;

/** True if an entry is known to be a painted material. @param {Entry} entry */
const isPaintedEntry = ({ source }) => source !== null && isStyle(source);

export class MaterialCache {
  /** @type {Map<string, Entry>} */
  #entries = new Map();
  #fetching = 0;
  #clock = 0;
  /** As in `Making`. */
  #painting = 0;
  #clearing = false;
  #changed;
  #pathOf;
  #linear;

  /**
   * @param {() => void} changed is called when something has arrived
   * @param {{pathOf?: (of: Source) => string, linear?: boolean}} [how] `pathOf`: the address of
   *   the code, default: of individuals; `linear`: true to draw linear light
   */
  constructor(changed, { pathOf = ofIndividual, linear = false } = {}) {
    this.#changed = changed;
    this.#pathOf = pathOf;
    this.#linear = linear;
  }

  /**
   * The material of an individual if it can be drawn in these environments, else null.
   * @param {Source} of
   * @param {Environment} environment
   */
  drawable(of, { key }) {
    const material = this.#entries.get(of.hash)?.material;
    const fits = material?.painted ? this.#painting > 0 : material && environmentOf(material) === key;
    const shows = this.#clearing || material?.index === null;
    return material?.drawable && fits && shows ? material : null;
  }

  /** True if a clear material was wanted last. */
  showsClear() {
    const wanted = [...this.#entries.values()].filter(({ used }) => used === this.#clock);
    return this.#clearing && wanted.some(({ isClear }) => isClear);
  }

  /** True if a material can never be drawn. @param {Source} of */
  isUnknown(of) {
    const entry = this.#entries.get(of.hash);
    if (entry === undefined) return false;
    // What the rays of an object beside the subject see is not known.
    if (this.#linear && entry.isClear) return true;
    return entry.refused || entry.material?.state === "refused";
  }

  /** True if the server or the driver refused the material. @param {Source} of */
  isRefused(of) {
    const entry = this.#entries.get(of.hash);
    if (entry && isPaintedEntry(entry) && this.#painting === 0) return true;
    if (entry?.isClear && !this.#clearing) return true;
    return entry !== undefined && (entry.hasFailed || entry.material?.state === "refused");
  }

  /**
   * Prepares wanted materials in order, few at a time, so that the page stays responsive.
   * @param {WebGL2RenderingContext} gl
   * @param {Source[]} wanted
   * @param {Making} scene
   * @returns {boolean} true if there is more to do
   */
  work(gl, wanted, scene) {
    this.#clock += 1;
    this.#painting = scene.painting;
    this.#clearing = scene.clearing;
    let busy = 0;
    for (const of of wanted) {
      const entry = this.#entry(of.hash);
      entry.used = this.#clock;
      const { fetching } = entry;
      const painted = isPaintedEntry(entry);
      const lights = painted ? scene.painting : scene.look.lights.length / METER_ANGLES;
      if (painted && lights === 0) continue;
      const outgrown =
        (entry.within < scene.within || (painted && entry.lights !== lights)) && !fetching;
      const key = painted ? "" : scene.environment.key;
      const elsewhere = entry.environment !== key && !fetching;
      if (
        entry.material &&
        (outgrown ||
          (elsewhere && (entry.environment === "" || key === "")) ||
          entry.material.lights !== lights)
      )
        this.#drop(gl, entry);
      if (outgrown) entry.source = null;
      if (elsewhere) {
        entry.environment = key;
        entry.file = null;
        // Another environment may not need what was refused.
        if (entry.hasFailed) entry.failed = entry.hasFailed = false;
      }
      const { material } = entry;
      if (entry.failed || material?.state === "refused") continue;
      if (material?.state === "ready" && environmentOf(material) === key) continue;
      if (entry.source === null || (entry.file === null && key !== "")) {
        if (!fetching && this.#fetching < FETCHES) void this.#fetch(of, entry, scene);
        continue;
      }
      if (busy === scene.together) continue;
      busy += 1;
      if (material && environmentOf(material) === entry.environment) {
        advance(gl, material, scene);
        continue;
      }
      const spheres = entry.file && makeSpheres(gl, entry.file, entry.environment);
      if (material) replaceSpheres(gl, material, spheres);
      else entry.material = makeMaterial(gl, entry.source, lights, spheres, this.#linear);
    }
    this.#forget(gl);
    return busy > 0;
  }

  /**
   * Measures all exposures again after object or lights have changed.
   * @param {WebGL2RenderingContext} gl
   */
  remeter(gl) {
    for (const { material } of this.#entries.values()) if (material) remeter(gl, material);
  }

  /** Drops the materials of a lost context, but not their code. */
  lose() {
    for (const entry of this.#entries.values()) entry.material = null;
  }

  /** @param {string} hash @returns {Entry} */
  #entry(hash) {
    const known = this.#entries.get(hash);
    if (known) return known;
    /** @type {Entry} */
    const entry = {
      source: null,
      isClear: false,
      within: 0,
      lights: 0,
      file: null,
      environment: "",
      material: null,
      fetching: false,
      failed: false,
      hasFailed: false,
      refused: false,
      used: 0,
    };
    this.#entries.set(hash, entry);
    return entry;
  }

  /** @param {WebGL2RenderingContext} gl @param {Entry} entry */
  #drop(gl, entry) {
    if (entry.material) dropMaterial(gl, entry.material);
    entry.material = null;
  }

  /** @param {Source} of @param {Entry} entry @param {Making} scene */
  async #fetch(of, entry, { within, environment, painting }) {
    entry.fetching = true;
    entry.within = within;
    entry.lights = Math.max(1, painting);
    this.#fetching += 1;
    try {
      entry.hasFailed = false;
      entry.source ??= await getText(
        `${this.#pathOf(of)}uv_within=${within}&lights=${entry.lights}`,
      );
      entry.isClear = indexOf(entry.source) !== null;
      const sceneId = sceneStore.scene.peek()?.id;
      if (environment.key !== "" && sceneId && !isStyle(entry.source)) {
        entry.file = await getSpheres(of.id, sceneId, environment.turns);
        // Anisotropic and textured materials have none: the server's pictures stay.
        entry.failed = entry.file.byteLength === 0;
        entry.hasFailed = entry.failed;
      }
    } catch (error) {
      // The server's picture stays, as without a GPU.
      entry.failed = true;
      entry.hasFailed = true;
      const { status } = problemOf(error);
      if (status === 0 || status >= 500) {
        setTimeout(() => {
          entry.failed = false;
          this.#changed();
        }, AGAIN_MS);
      } else entry.refused = true;
    }
    entry.fetching = false;
    this.#fetching -= 1;
    this.#changed();
  }

  /** @param {WebGL2RenderingContext} gl */
  #forget(gl) {
    if (this.#entries.size <= KEPT) return;
    const old = [...this.#entries].filter(
      ([, entry]) => entry.used < this.#clock && !entry.fetching,
    );
    old.sort(([, a], [, b]) => a.used - b.used);
    for (const [hash, entry] of old.slice(0, this.#entries.size - KEPT)) {
      this.#drop(gl, entry);
      this.#entries.delete(hash);
    }
  }
}
