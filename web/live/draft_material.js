/**
 * Material of a genome that is edited and not stored. Its code is printed, and its lit spheres are
 * computed by the server for the newest values, one request at a time; the material before stays
 * drawable until the next is. The values are literals in the code, as for all materials, because
 * uniforms draw at half the speed.
 *
 * @import { Draft } from "../model.js"
 * @import { Look, Material, Meter } from "./material.js"
 * @import { Environment } from "./spheres.js"
 * @import { SurfacePrograms } from "./surface.js"
 */
import { problemOf } from "../api/request.js";
import { printGenome } from "../api/routes.js";
import { genomeIn, isByBrdf } from "../lineage/layers.js";
import { forNewest } from "../page/newest.js";
import { showProblem } from "../page/problem.js";
import { sceneStore } from "../scene/store.js";
import {
  METER_ANGLES, advance, dropMaterial, environmentOf, makeMaterial, remeter,
} from "./material.js";
import { indexOf } from "./paint.js";
import { NO_ENVIRONMENT, lightGenome, makeSpheres } from "./spheres.js";
import { liveStore } from "./store.js";

/**
 * @typedef {{text: string, within: number, environment: Environment}} Asked `within`: bound on
 *   texture coordinates
 *
 * @typedef {{code: string, file: ArrayBuffer|null, key: string}} Answer `file`: lit spheres in the
 *   environments of this key
 */

/** @type {Asked} */
const NOTHING = { text: "", within: 0, environment: NO_ENVIRONMENT };

export class DraftMaterial {
  /** Id of the edited individual. */
  #id = "";
  /** The newest request. */
  #asked = NOTHING;
  /** True if only the server draws the newest answer, in any scene. */
  #refused = false;
  /** Newest answer. @type {Answer|null} */
  #answer = null;
  /** Answer of `#next`, or of `#shown` if there is none. @type {Answer|null} */
  #made = null;
  /** @type {Material|null} */
  #next = null;
  /** @type {Material|null} */
  #shown = null;
  /** As in `Making`. */
  #clearing = false;
  #changed;

  /** @param {() => void} changed is called when an answer has arrived */
  constructor(changed) {
    this.#changed = changed;
  }

  /**
   * The newest material that can be drawn in these environments, or null.
   * @param {Environment} environment
   */
  drawable({ key }) {
    const shown = this.#clearing || this.#shown?.index === null ? this.#shown : null;
    return shown && environmentOf(shown) === key ? shown : null;
  }

  /** True if the draft is clear. */
  isClear() {
    return this.#answer !== null && indexOf(this.#answer.code) !== null;
  }

  /**
   * Brings the material closer to the draft.
   * @param {WebGL2RenderingContext} gl
   * @param {Draft|null} draft null if nothing is edited
   * @param {{meter: Meter, look: Look, pens: SurfacePrograms, within: number, environment:
   *   Environment, clearing: boolean}} scene as for the other materials
   * @returns {boolean} true if there is more to do
   */
  work(gl, draft, scene) {
    if (!draft) return false;
    if (draft.of.id !== this.#id) {
      this.drop(gl);
      this.#id = draft.of.id;
    }
    const { within, environment } = scene;
    this.#clearing = scene.clearing;
    liveStore.draftRefused.value = this.#refused || (this.isClear() && !scene.clearing);
    const lights = scene.look.lights.length / METER_ANGLES;
    const asked = this.#asked;
    if (
      asked.text !== draft.text ||
      asked.within !== within ||
      asked.environment.key !== environment.key
    ) {
      this.#asked = { text: draft.text, within, environment };
      void this.#ask({ id: this.#id, asked: this.#asked });
    }
    if ([this.#next, this.#shown].some((one) => one && one.lights !== lights))
      this.#dropMaterials(gl);
    const answer = this.#answer;
    if (!answer && this.#shown) this.#dropMaterials(gl);
    if (!this.#next && answer && answer !== this.#made) {
      const spheres = answer.file && makeSpheres(gl, answer.file, answer.key);
      this.#next = makeMaterial(gl, answer.code, lights, spheres);
      this.#made = answer;
    }
    const busy = [this.#next, this.#shown].flatMap((one) =>
      one && one.state !== "ready" && one.state !== "refused" ? [one] : [],
    );
    for (const material of busy)
      if (environmentOf(material) === environment.key) advance(gl, material, scene);
    if (this.#next && environmentOf(this.#next) !== environment.key) {
      dropMaterial(gl, this.#next);
      this.#next = null;
    } else if (this.#next?.drawable) {
      if (this.#shown) dropMaterial(gl, this.#shown);
      this.#shown = this.#next;
      this.#next = null;
    } else if (this.#next?.state === "refused") {
      dropMaterial(gl, this.#next);
      this.#next = null;
    }
    return busy.length > 0;
  }

  /**
   * Measures the exposure again after object or lights have changed.
   * @param {WebGL2RenderingContext} gl
   */
  remeter(gl) {
    for (const material of [this.#next, this.#shown]) if (material) remeter(gl, material);
  }

  /** Forgets the materials of a lost context, but not the answer. */
  lose() {
    this.#next = null;
    this.#shown = null;
    this.#made = null;
  }

  #ask = forNewest(
    /** @param {{id: string, asked: Asked}} of */ async ({ id, asked }) => {
      const { text, within, environment } = asked;
      if (isByBrdf(genomeIn(text))) {
        // It has no code: the server draws it.
        this.#refused = true;
        this.#answer = null;
        this.#changed();
        return;
      }
      try {
        const [code, file] = await Promise.all([
          printGenome(text, within),
          this.#light(text, environment),
        ]);
        if (this.#id === id) {
          // Anisotropic and textured materials have no spheres: the server draws them.
          this.#refused = file?.byteLength === 0;
          this.#answer = file?.byteLength === 0 ? null : { code, file, key: environment.key };
        }
      } catch (error) {
        if (this.#id === id) showProblem("edit", { problem: problemOf(error) });
      }
      this.#changed();
    },
  );

  /**
   * @param {string} text
   * @param {Environment} environment
   */
  async #light(text, { key, turns }) {
    const sceneId = sceneStore.scene.peek()?.id;
    return key !== "" && sceneId ? lightGenome(text, sceneId, turns) : null;
  }

  /** @param {WebGL2RenderingContext} gl */
  #dropMaterials(gl) {
    for (const material of [this.#next, this.#shown]) if (material) dropMaterial(gl, material);
    this.lose();
  }

  /** Forgets everything, because nothing is edited. @param {WebGL2RenderingContext} gl */
  drop(gl) {
    this.#dropMaterials(gl);
    this.#id = "";
    this.#asked = NOTHING;
    this.#answer = null;
    this.#refused = false;
    liveStore.draftRefused.value = false;
  }
}
