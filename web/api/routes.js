/**
 * The server's routes as functions, except those of targets and searches (`search/routes.js`).
 * Independent of the page's state.
 *
 * @import { Comparison, Dialect, ExportFormat, Generation, Individual, Inspection, Knobs, Lineage,
 *   Locks, MeshAnswer, ModelInfo, Painting, Preset, Scene, Start, SystemAnswer } from "../model.js"
 *
 * @typedef {ReturnType<typeof import("./upload.js").sendingBy>} Send replaces fetch
 */
import { patch, post, read, readAll, request } from "./request.js";

/** @returns {Promise<SystemAnswer>} */
export const getSystem = () => request("GET", "/v1/system");

/** @param {string} token */
export const createSession = (token) =>
  request("POST", "/v1/session", { json: { token }, asks: false });

export const deleteSession = () => request("DELETE", "/v1/session", { asks: false });

/**
 * @param {{search?: string, hidden?: boolean}} [filter]
 * @returns {Promise<Lineage[]>}
 */
export const listLineages = ({ search = "", hidden = false } = {}) =>
  readAll(
    "/v1/lineages",
    `${search && `&search=${encodeURIComponent(search)}`}${hidden ? "&hidden=true" : ""}`,
  );

/**
 * Reads a page of favourites.
 * @param {string|null} lineage null for all
 * @param {string|null} cursor null for the first page
 * @returns {Promise<{items: import("../model.js").Favourite[], next: string|null}>}
 */
export const listFavourites = (lineage, cursor) =>
  request(
    "GET",
    `/v1/individuals?favourite=true&limit=48${lineage ? `&lineage=${lineage}` : ""}${cursor ? `&cursor=${cursor}` : ""}`,
  );

/** @param {string} id @returns {Promise<Lineage>} */
export const getLineage = (id) => request("GET", `/v1/lineages/${id}`);

/**
 * @param {{name: string, scene?: string, thumbnail_px: number, saturation: number, start?:
 *   Start, dialect?: Partial<Dialect>, energy_limit?: boolean}} json
 * @returns {Promise<Lineage>}
 */
export const createLineage = (json) => request("POST", "/v1/lineages", { json });

/**
 * @param {Lineage} of
 * @param {{name?: string, notes?: string, tags?: string[], hidden?: boolean, cover_individual?:
 *   string|null, scene?: string, saturation?: number, energy_limit?: boolean}} json
 * @returns {Promise<Lineage>}
 */
export const patchLineage = (of, json) => patch(`/v1/lineages/${of.id}`, of.version, json);

/**
 * Gives a lineage another scene; fails with 412 if another client has changed the lineage
 * meanwhile.
 * @param {Lineage} of
 * @param {string} scene
 * @returns {Promise<Lineage>}
 */
export const patchScene = (of, scene) =>
  request("PATCH", `/v1/lineages/${of.id}`, { json: { scene }, version: of.version });

/** @param {Lineage} of */
export async function hideLineage(of) {
  const path = `/v1/lineages/${of.id}`;
  const present = await request("GET", path);
  return request("DELETE", path, { version: present.version });
}

/**
 * Reads a page of a lineage's history.
 * @param {string} lineageId
 * @param {string|null} cursor null for the first page
 * @returns {Promise<{items: import("../model.js").GenerationOutline[], next: string|null}>}
 */
export const listOutlines = (lineageId, cursor) =>
  request("GET", `/v1/lineages/${lineageId}/outlines?limit=200${cursor ? `&cursor=${cursor}` : ""}`);

/**
 * Reads the newest generation, if there is one.
 * @param {Lineage} of
 * @returns {Promise<Generation|null>}
 */
export async function getNewestGeneration(of) {
  const after = of.generations > 1 ? `&cursor=${of.generations - 2}` : "";
  const { items } = await request("GET", `/v1/lineages/${of.id}/generations?limit=1${after}`);
  return items.at(-1) ?? null;
}

/** @param {string} id @returns {Promise<Generation>} */
export const getGeneration = (id) => request("GET", `/v1/generations/${id}`);

/**
 * @param {string} lineageId
 * @param {{parents: string[], knobs: Knobs, locks?: Locks, count: number}} how `locks`: only with
 *   parents
 * @returns {Promise<Generation>}
 */
export const breed = (lineageId, { parents, knobs, locks, count }) =>
  request("POST", `/v1/lineages/${lineageId}/generations`, {
    json: {
      parents,
      count,
      mutation: knobs.mutation,
      recombination: knobs.recombination,
      saturation: knobs.saturation,
      energy_limit: knobs.energy_limit,
      locks,
      // Children are compared with a parent.
      steer: parents.length > 0 ? knobs.steer : [],
      painting: knobs.painting ?? undefined,
      curation: "diverse",
      constraints: {
        isotropic: knobs.isotropic,
        homogeneous: knobs.homogeneous,
        bumps: knobs.bumps,
      },
    },
  });

/**
 * Colours of a picture by regions.
 * @param {File} file
 * @param {Send} send
 * @returns {Promise<Painting>}
 */
export const readPalette = (file, send) =>
  request("POST", "/v1/palettes", { body: file, send, type: file.type });

/**
 * Stores an image for effects.
 * @param {File} file
 * @param {Send} send
 * @returns {Promise<{id: string, width: number, height: number}>}
 */
export const createImage = (file, send) =>
  request("POST", "/v1/images", { body: file, send, type: file.type });

/** @param {string} id of an image */
export const imageUrl = (id) => `/v1/images/${id}`;

/** @param {string} hash */
export const getGenomeText = async (hash) =>
  (await read(`/v1/genomes/${hash}`, { accept: "text/x-brood" })).text();

/** @returns {Promise<Preset[]>} */
export const listPresets = () => request("GET", "/v1/presets");

/** @returns {Promise<ExportFormat[]>} */
export const listExports = () => request("GET", "/v1/exports");

/** @returns {Promise<ModelInfo[]>} */
export const listModels = () => request("GET", "/v1/models");

/** @param {string} text @returns {import("./request.js").Options} */
const asGenome = (text) => ({ body: new Blob([text]), type: "text/x-brood", accept: "*/*" });

/** Sends a genome. @param {string} path @param {string} text */
export const postGenome = (path, text) => post(path, asGenome(text));

/**
 * The GLSL of a genome, which the server does not store.
 * @param {string} text
 * @param {number} within bound on texture coordinates
 */
export const printGenome = async (text, within) =>
  (await postGenome(`/v1/exports/glsl-es-300?uv_within=${within}`, text)).text();

/**
 * The mean light of an environment.
 * @param {string} image
 * @returns {Promise<import("../model.js").EnvironmentMean>}
 */
export const meanOfEnvironment = (image) => request("GET", `/v1/environments/${image}/mean`);

/**
 * A picture of a genome, which the server does not store.
 * @param {string} text
 * @param {string} sceneId
 * @param {number} size
 */
export const renderGenome = async (text, sceneId, size) =>
  (await postGenome(`/v1/render.png?scene=${sceneId}&size=${size}`, text)).blob();

/**
 * Adds genomes to a lineage as they are; `parent`: individual whose children they are.
 * @param {string} lineageId
 * @param {{genomes?: string[], presets?: string[], parent?: string}} json
 * @returns {Promise<Generation>}
 */
export const adopt = (lineageId, json) =>
  request("POST", `/v1/lineages/${lineageId}/adoptions`, { json });

/** @param {Blob} file text or JSON @returns {Promise<{hash: string}>} */
export async function createGenome(file) {
  const text = await file.text();
  const type = text.trimStart().startsWith("{") ? "application/json" : "text/x-brood";
  return request("POST", "/v1/genomes", { body: new Blob([text]), type });
}

/** @param {Blob} file a lineage with its whole history @returns {Promise<Lineage>} */
export const importLineage = (file) =>
  request("POST", "/v1/lineages/import", { body: file, type: "application/json" });

/** @param {string} hash @returns {Promise<import("../model.js").GenomeJson>} */
export const getGenome = (hash) => request("GET", `/v1/genomes/${hash}`);

/** @param {string} id @returns {Promise<import("../model.js").Favourite>} */
export const getIndividual = (id) => request("GET", `/v1/individuals/${id}`);

/** @param {string} id @returns {Promise<Inspection>} */
export const getInspection = (id) => request("GET", `/v1/individuals/${id}/inspection`);

/**
 * @param {Individual} of
 * @param {{favourite?: boolean, note?: string}} json
 * @returns {Promise<Individual>}
 */
export const patchIndividual = (of, json) => patch(`/v1/individuals/${of.id}`, of.version, json);

/** @param {string} id @returns {Promise<Scene>} */
export const getScene = (id) => request("GET", `/v1/scenes/${id}`);

/** @param {Partial<Scene>} scene what is absent has defaults @returns {Promise<Scene>} */
export function createScene(scene) {
  const { id: _, ...json } = scene;
  return request("POST", "/v1/scenes", { json });
}

/** @param {string} id @returns {Promise<import("../model.js").MeshAnswer>} */
export const getMesh = (id) => request("GET", `/v1/meshes/${id}`);

/** @param {Blob} file @param {Send} send @returns {Promise<MeshAnswer>} */
export const createMesh = (file, send) =>
  request("POST", "/v1/meshes", { body: file, type: "model/obj", send });

/** @param {File} file @param {Send} send @returns {Promise<{id: string}>} */
export const createProfile = (file, send) =>
  request("POST", "/v1/profiles", { body: file, type: "application/x-ies", send });

/** @param {File} file @param {Send} send @returns {Promise<{id: string}>} */
export const createEnvironment = (file, send) =>
  request("POST", "/v1/environments", {
    body: file,
    send,
    type: /\.exr$/i.test(file.name) ? "image/x-exr" : "image/vnd.radiance",
  });

/**
 * @param {string} id
 * @param {string} sceneId
 * @param {number} size
 * @param {number} [light_deg] default: the scene's own
 */
export const pictureUrl = (id, sceneId, size, light_deg) =>
  `/v1/individuals/${id}/render.png?size=${size}&scene=${sceneId}${light_deg === undefined ? "" : `&light_deg=${light_deg}`}`;

/**
 * Measures materials side by side.
 * @param {string[]} materials individuals by id, genomes by hash
 * @param {string} sceneId
 * @param {number} size
 * @returns {Promise<import("../model.js").Comparison>}
 */
export const compare = (materials, sceneId, size) =>
  request("GET", `/v1/comparison?materials=${materials.join()}&scene=${sceneId}&size=${size}`);

/** @param {string} id @param {number} size */
export const sliceUrl = (id, size) => `/v1/individuals/${id}/slice.png?size=${size}`;

/** @param {string} lineageId */
export const eventsUrl = (lineageId) => `/v1/lineages/${lineageId}/events`;
