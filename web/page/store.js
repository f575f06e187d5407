/**
 * Store of the page as a whole: open panes and dialogs, the focused frame, messages, display
 * switches. Independent of lineages, scenes and searches.
 *
 * @import { Cell, Download, Place, Problem, ShownProblem, SystemAnswer } from "../model.js"
 * @import { Signal } from "../vendor/signals-core.js"
 */
import { signal } from "../vendor/signals-core.js";

class PageStore {
  /** @type {Signal<SystemAnswer|null>} */
  serverInfo = signal(null);
  /** True while the event stream is broken. @type {Signal<boolean>} */
  connectionLost = signal(false);
  /**
   * Problems by the place on the page that shows them.
   * @type {Signal<Partial<Record<Place, ShownProblem>>>}
   */
  problems = signal({});
  /** Text of the live region for screen readers. @type {Signal<string>} */
  announcement = signal("");
  /** Running downloads by the name of their file. @type {Signal<Map<string, Download>>} */
  downloads = signal(new Map());
  /** True while a file is dragged over the window. @type {Signal<boolean>} */
  fileDragged = signal(false);
  /** The frame that the Tab key reaches. @type {Signal<Cell>} */
  focusedCell = signal("centre");
  /** Left pane; closed at first where it would cover the frames. @type {Signal<boolean>} */
  knobsOpen = signal(globalThis.innerWidth > 900);
  /** Right pane. @type {Signal<boolean>} */
  detailsOpen = signal(globalThis.innerWidth > 1180);
  /** @type {Signal<boolean>} */
  lineagesOpen = signal(false);
  /** @type {Signal<boolean>} */
  presetsOpen = signal(false);
  /** @type {Signal<boolean>} */
  helpOpen = signal(false);
  /** Lineages of others, reported on a first visit until dismissed. @type {Signal<number>} */
  othersFound = signal(0);
  /** True for a surround of 18 % grey, false for near-black. @type {Signal<boolean>} */
  greySurround = signal(false);
  /** @type {Signal<boolean>} */
  hintShown = signal(true);
  /** True if burnt-out and black pixels are marked. @type {Signal<boolean>} */
  clippingShown = signal(false);
  /** True while the dialog that asks for an access token is open. @type {Signal<boolean>} */
  tokenAsked = signal(false);
  /**
   * True if this browser was given a token; scripts cannot read the token itself.
   * @type {Signal<boolean>}
   */
  tokenGiven = signal(false);
  /** Reason why the server refused the last token. @type {Signal<Problem|null>} */
  tokenRefusal = signal(null);
}

export const pageStore = new PageStore();
