/**
 * Store of the state that components keep while they are closed or redrawn: sizes, copied texts,
 * names being edited, choices of charts.
 *
 * @import { Start } from "../model.js"
 * @import { Signal } from "../vendor/signals-core.js"
 */
import { signal } from "../vendor/signals-core.js";

class ViewStore {
  /** Side of the large picture on the screen, device pixels. @type {Signal<number>} */
  centre_px = signal(0);
  /** Address to copy by hand where the browser has no clipboard. @type {Signal<string|null>} */
  link = signal(null);
  /** True for a moment after the address was copied. @type {Signal<boolean>} */
  linkCopied = signal(false);
  /** True for a moment after code was copied. @type {Signal<boolean>} */
  codeCopied = signal(false);
  /** Exposure while its slider is dragged, EV. @type {Signal<number|null>} */
  draggedExposure = signal(null);
  /** Id of the lineage whose name is being edited. @type {Signal<string|null>} */
  renaming = signal(null);
  /** Id of the lineage that is about to be hidden. @type {Signal<string|null>} */
  hiding = signal(null);
  /** Content of a new lineage. @type {Signal<Start|"presets">} */
  startKind = signal("believable");
  /**
   * Columns of the history that are drawn, counted from the oldest generation.
   * @type {Signal<{from: number, to: number}>}
   */
  stripColumns = signal({ from: 0, to: 40 });
  /** Effect of a click on a preset. @type {Signal<"begin"|"cross">} */
  presetUse = signal("begin");
  /**
   * True if exported functions are under the energy limit, which other renderers rely on.
   * @type {Signal<boolean>}
   */
  limitedExports = signal(true);
  /** Width and height of exported pictures, as typed. */
  exportSides = signal({ width: "1024", height: "1024" });
  /** Scale chosen for each chart, by its id. @type {Signal<Record<string, string>>} */
  chartScales = signal({});
  /** Horizontal axis of the chart of errors. @type {Signal<"seconds"|"generation">} */
  errorAxis = signal("seconds");
  /**
   * Picture that is shown before a search, and its target.
   * @type {Signal<{of: string, view: number}>}
   */
  understoodView = signal({ of: "", view: 0 });
  /**
   * Addresses of a target's pictures that the server could not draw.
   * @type {Signal<Set<string>>}
   */
  failedTargetPictures = signal(new Set());
}

export const viewStore = new ViewStore();
