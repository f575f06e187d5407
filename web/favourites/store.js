/**
 * Store of the favourites of all lineages: what is listed, and what is chosen for a download or a
 * comparison.
 *
 * @import { Favourite } from "../model.js"
 * @import { Signal } from "../vendor/signals-core.js"
 */
import { computed, signal } from "../vendor/signals-core.js";
import { lineageStore } from "../lineage/store.js";

/** Part of the address that lists the favourites of all lineages. */
export const ALL = "all";

/** Side of the large pictures, and how many are requested at a time. */
const LARGE_PX = 512;
const AT_ONCE = 2;

/** Address of a large picture in the light of its lineage. @param {string} id */
export const largeUrl = (id) => `/v1/individuals/${id}/render.png?size=${LARGE_PX}`;

class FavouritesStore {
  /** Lineage whose favourites are shown, or ALL; null while closed. @type {Signal<string|null>} */
  openOf = signal(null);
  /**
   * Favourites read so far, newest first; null before the first.
   * @type {Signal<Favourite[]|null>}
   */
  items = signal(null);
  /** @type {Signal<string|null>} */
  nextCursor = signal(null);
  /** Ids of those whose mark was removed since the list was read. @type {Signal<Set<string>>} */
  removed = signal(new Set());
  /** Id of the one that is being opened or imported. @type {Signal<string|null>} */
  busyId = signal(null);
  /** Ids of those that are chosen. @type {Signal<Set<string>>} */
  chosenIds = signal(new Set());

  /**
   * Ids of those whose large pictures are requested: those that have loaded, and the next two. More
   * would occupy the few connections of the browser, which actions need.
   * @type {Signal<Set<string>>}
   */
  large = computed(() => {
    const ids = new Set();
    let pending = 0;
    for (const { id } of this.items.value ?? []) {
      const url = largeUrl(id);
      const isDone =
        lineageStore.loadedPictures.value.has(url) || lineageStore.failedPictures.value.has(url);
      if (!isDone) pending += 1;
      if (pending > AT_ONCE) break;
      ids.add(id);
    }
    return ids;
  });
  /** Chosen favourites in the order of the list. @type {Signal<Favourite[]>} */
  chosen = computed(() =>
    (this.items.value ?? []).filter(({ id }) => this.chosenIds.value.has(id)),
  );
}

export const favouritesStore = new FavouritesStore();
