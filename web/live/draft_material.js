/**
 * Material of a genome that is edited and not stored. Its code is printed by the server for the
 * newest values, one request at a time; the material before stays drawable until the next is. The
 * values are literals in the code, as for all materials, because uniforms draw at half the speed.
 *
 * @import { Draft } from "../model.js"
 * @import { Look, Material, Meter } from "./material.js"
 * @import { SurfacePrograms } from "./surface.js"
 */
import { problemOf } from "../api/request.js";
import { printGenome } from "../api/routes.js";
import { forNewest } from "../page/newest.js";
import { showProblem } from "../page/problem.js";
import { METER_ANGLES, advance, dropMaterial, makeMaterial, remeter } from "./material.js";

export class DraftMaterial {
  /** Id of the edited individual. */
  #id = "";
  /** Text and bound on texture coordinates of the newest request. */
  #asked = { text: "", within: 0 };
  /** Newest code. @type {string|null} */
  #code = null;
  /** Code of `#next`, or of `#shown` if there is none. @type {string|null} */
  #made = null;
  /** @type {Material|null} */
  #next = null;
  /** @type {Material|null} */
  #shown = null;
  #changed;

  /** @param {() => void} changed is called when code has arrived */
  constructor(changed) {
    this.#changed = changed;
  }

  /** The newest material that can be drawn, or null. */
  get drawable() {
    return this.#shown;
  }

  /**
   * Brings the material closer to the draft.
   * @param {WebGL2RenderingContext} gl
   * @param {Draft|null} draft null if nothing is edited
   * @param {{meter: Meter, look: Look, pens: SurfacePrograms, within: number}} scene as for the
   *   other materials
   * @returns {boolean} true if there is more to do
   */
  work(gl, draft, scene) {
    if (!draft) return false;
    if (draft.of.id !== this.#id) {
      this.drop(gl);
      this.#id = draft.of.id;
    }
    const { within } = scene;
    const lights = scene.look.lights.length / METER_ANGLES;
    if (this.#asked.text !== draft.text || this.#asked.within !== within) {
      this.#asked = { text: draft.text, within };
      void this.#print({ id: this.#id, ...this.#asked });
    }
    if ([this.#next, this.#shown].some((one) => one && one.lights !== lights))
      this.#dropMaterials(gl);
    if (!this.#next && this.#code !== null && this.#code !== this.#made) {
      this.#next = makeMaterial(gl, this.#code, lights, null);
      this.#made = this.#code;
    }
    const busy = [this.#next, this.#shown].flatMap((one) =>
      one && one.state !== "ready" && one.state !== "refused" ? [one] : [],
    );
    for (const material of busy) advance(gl, material, scene);
    if (this.#next?.drawable) {
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

  /** Forgets the materials of a lost context, but not their code. */
  lose() {
    this.#next = null;
    this.#shown = null;
    this.#made = null;
  }

  #print = forNewest(
    /** @param {{id: string, text: string, within: number}} of */ async ({ id, text, within }) => {
      try {
        const code = await printGenome(text, within);
        if (this.#id === id) this.#code = code;
      } catch (error) {
        if (this.#id === id) showProblem("edit", { problem: problemOf(error) });
      }
      this.#changed();
    },
  );

  /** @param {WebGL2RenderingContext} gl */
  #dropMaterials(gl) {
    for (const material of [this.#next, this.#shown]) if (material) dropMaterial(gl, material);
    this.lose();
  }

  /** Forgets everything, because nothing is edited. @param {WebGL2RenderingContext} gl */
  drop(gl) {
    this.#dropMaterials(gl);
    this.#id = "";
    this.#asked = { text: "", within: 0 };
    this.#code = null;
  }
}
