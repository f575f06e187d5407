/**
 * Store of the open lineage: its generations, the one that is shown, how the next brood is bred,
 * and what the server said about genomes. Does no requests and no drawing.
 *
 * @import { Draft, Edit, ExportFormat, Generation, Genome, Individual, Inspection, Knobs, Lineage,
 *   Locks, ModelInfo, Outline, Preset, Trail } from "../model.js"
 * @import { Signal } from "../vendor/signals-core.js"
 * @import { Descent } from "./history.js"
 */
import { computed, signal } from "../vendor/signals-core.js";
import { ancestry, descentOf, links } from "./history.js";
import { isByBrdf, isPainted } from "./layers.js";
import { hasValues, withParameters } from "./parameters.js";

/** Number of frames around the centre. */
export const FRAMES = 20;

/** Saturation for breeding by eye: the three channels evolve independently and look garish at 1. */
export const DEFAULT_SATURATION = 0.65;

/** @returns {Locks} */
export const noLocks = () => ({
  instructions: [],
  constants: [],
  channels: [],
  layers: [],
  parameters: [],
  effects: [],
  effect_parameters: [],
  bump: false,
});

/** True if a generation is one genome that was edited by hand. @param {Outline} of */
const isEdit = ({ individuals, parents }) =>
  individuals.length === 1 && individuals[0].operator === "adopt" && parents.length > 0;

/**
 * The individual that a generation shows large: the centre, or the first child if it has no
 * parents or is an edit of its parent.
 * @param {Outline} of
 * @returns {Individual|null}
 */
export const centreOf = (of) => (isEdit(of) ? null : of.centre) ?? of.individuals[0] ?? null;

/** Generations by index. @param {Map<string, Outline>} of */
export const inOrder = (of) => [...of.values()].sort((a, b) => a.index - b.index);

class LineageStore {
  /** @type {Signal<Lineage[]>} */
  lineages = signal([]);
  /**
   * Filter of the list of lineages.
   * @type {Signal<{search: string, hidden: boolean}>}
   */
  listFilter = signal({ search: "", hidden: false });
  /** Lineages that the filter selects. @type {Signal<Lineage[]>} */
  found = signal([]);
  /** The open lineage. @type {Signal<Lineage|null>} */
  lineage = signal(null);
  /**
   * Generations of the open lineage by id; replaced, never changed in place. Those that were used
   * last are whole (`storeRead`).
   * @type {Signal<Map<string, Outline>>}
   */
  generations = signal(new Map());
  /** Id of the generation that is shown. @type {Signal<string|null>} */
  shownId = signal(null);
  /** @type {Signal<Trail>} */
  trail = signal({ past: [], future: [] });
  /** Individual marked as the second parent. @type {Signal<Individual|null>} */
  mate = signal(null);
  /** @type {Signal<Knobs>} */
  knobs = signal({
    mutation: 0.3,
    recombination: 0.5,
    isotropic: false,
    homogeneous: false,
    bumps: null,
    saturation: DEFAULT_SATURATION,
    energy_limit: false,
    steer: [],
    painting: null,
  });
  /** Parts of the parent that children keep. @type {Signal<Locks>} */
  locks = signal(noLocks());
  /** True while a brood is being bred. @type {Signal<boolean>} */
  breeding = signal(false);
  /** Milliseconds from the click to the last picture. @type {Signal<number|null>} */
  elapsed_ms = signal(null);

  /** Addresses of pictures that are loaded. @type {Signal<Set<string>>} */
  loadedPictures = signal(new Set());
  /** Addresses of pictures that failed several times. @type {Signal<Set<string>>} */
  failedPictures = signal(new Set());
  /**
   * Reasons for which the server refuses pictures, by address. These are also failed.
   * @type {Signal<Map<string, string>>}
   */
  refusedPictures = signal(new Map());
  /**
   * Retries by address. Part of the image's key, so that each retry is a new request.
   * @type {Signal<Map<string, number>>}
   */
  pictureRetries = signal(new Map());
  /** Id of the generation whose pictures are all loaded. @type {Signal<string|null>} */
  readyId = signal(null);

  /**
   * Changes by other clients to read once the scene has settled.
   * @type {Signal<"nothing"|"lineage"|"everything">}
   */
  pendingSync = signal("nothing");
  /** Last news of a search whose results are born in the open lineage. @type {Signal<any>} */
  jobNews = signal(null);

  /** Genomes read so far, by hash. @type {Signal<Map<string, Genome>>} */
  genomes = signal(new Map());
  /** Inspections read so far, by genome hash. @type {Signal<Map<string, Inspection>>} */
  inspections = signal(new Map());
  /** Individual in the genome inspector. @type {Signal<{of: Individual, name: string}|null>} */
  inspected = signal(null);
  /** True if the inspector hides dead instructions. @type {Signal<boolean>} */
  liveOnly = signal(false);
  /** @type {Signal<"assembly"|"scalar">} */
  codeKind = signal("assembly");
  /**
   * Options of the polar plot.
   * @type {Signal<{plane: number, color: "luminance"|"r"|"g"|"b", cosine: boolean, log:
   *   boolean}>}
   */
  polarOptions = signal({ plane: 0, color: "luminance", cosine: false, log: false });
  /** @type {Signal<Preset[]>} */
  presets = signal([]);
  /** Models with the ranges of their parameters, by name. @type {Signal<Map<string, ModelInfo>>} */
  models = signal(new Map());
  /** True if the details show controls for parameters. @type {Signal<boolean>} */
  editing = signal(false);
  /** Edit of the centre, or of the last centre until its own is read. @type {Signal<Edit|null>} */
  edit = signal(null);
  /** Key of the place of an effect chosen for an image. @type {Signal<string>} */
  imagePlace = signal("");
  /**
   * Share of the image there, if the slider was moved; `of`: id of the individual.
   * @type {Signal<{of: string, share: number}|null>}
   */
  imageShare = signal(null);
  /** Languages in which the server exports source code. @type {Signal<ExportFormat[]>} */
  exportFormats = signal([]);

  /** The generation that is shown, which is whole. @type {Signal<Generation|null>} */
  generation = computed(
    () =>
      /** @type {Generation|undefined} */ (this.generations.value.get(this.shownId.value ?? "")) ??
      null,
  );
  /** The individual shown large. @type {Signal<Individual|null>} */
  centre = computed(() => this.generation.value && centreOf(this.generation.value));
  /** The centre as it was edited; null if it was not. @type {Signal<Draft|null>} */
  draft = computed(() => {
    const edit = this.edit.value;
    if (!this.editing.value || !edit || edit.of.id !== this.centre.value?.id) return null;
    if (hasValues(edit.text, edit.layers)) return null;
    return { of: edit.of, text: withParameters(edit.text, edit.layers) };
  });
  /** Generations by index. @type {Signal<Outline[]>} */
  ordered = computed(() => inOrder(this.generations.value));
  /** @type {Signal<Descent>} */
  descent = computed(() => descentOf(this.ordered.value));
  /**
   * Generations in the strip, the path to the shown one, and every link; scrolling changes none.
   * @type {Signal<{all: Outline[], path: Set<string>, every: ReturnType<typeof links>}>}
   */
  strip = computed(() => {
    const path = ancestry(this.descent.value.parents, this.shownId.value);
    return { all: this.descent.value.inOrder, path, every: links(this.descent.value, path) };
  });
  /**
   * True if all genomes of the lineage are programs: it began with programs and nothing was
   * imported.
   * @type {Signal<boolean>}
   */
  programsOnly = computed(
    () =>
      (this.lineage.value?.dialect.length ?? 0) > 0 &&
      !this.ordered.value.some((born) => born.individuals[0]?.operator === "adopt"),
  );
  /** Genome of the centre; null until it is read. @type {Signal<Genome|null>} */
  centreGenome = computed(() => this.genomes.value.get(this.centre.value?.hash ?? "") ?? null);
  /**
   * True if the next brood is painted: the centre is, or the lineage starts with painted materials
   * and has no centre yet.
   * @type {Signal<boolean>}
   */
  painted = computed(() =>
    this.centreGenome.value
      ? isPainted(this.centreGenome.value)
      : this.lineage.value?.start === "painted",
  );
  /** True if the next brood is painted and has no BRDF. @type {Signal<boolean>} */
  withoutBrdf = computed(() => this.painted.value && !isByBrdf(this.centreGenome.value));
}

export const lineageStore = new LineageStore();
