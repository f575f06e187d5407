/**
 * Order of generations: descent, undo and redo, and the arcs of the strip. Pure functions; none
 * removes a generation.
 *
 * @import { Outline, Trail } from "../model.js"
 */

/**
 * @typedef {{inOrder: Outline[], known: Set<string>, parents: Map<string, string>}} Descent
 *   Generations by index, their ids, and for each the generation that it was bred from.
 */

/**
 * @param {Outline[]} inOrder by index
 * @returns {Descent}
 */
export function descentOf(inOrder) {
  return {
    inOrder,
    known: new Set(inOrder.map((generation) => generation.id)),
    parents: parentGenerations(inOrder),
  };
}

/**
 * For each generation the one that it was bred from: where its first parent was born. Roots have
 * none. `from` is used where it is known, because the parent may not be in the store any more.
 * @param {Outline[]} inOrder by index
 * @returns {Map<string, string>}
 */
function parentGenerations(inOrder) {
  const born = new Map();
  const parents = new Map();
  for (const generation of inOrder) {
    const first = generation.parents[0];
    const from = generation.from ?? (first === undefined ? undefined : born.get(first));
    if (from !== undefined) parents.set(generation.id, from);
    if (from !== undefined && generation.centre) born.set(generation.centre.id, from);
    for (const individual of generation.individuals) {
      born.set(individual.id, generation.id);
      // A parent may be named by its genome's hash; that means the first individual with it.
      if (!born.has(individual.hash)) born.set(individual.hash, generation.id);
    }
  }
  return parents;
}

/**
 * Ids of a generation and of all its ancestors.
 * @param {Map<string, string>} parents
 * @param {string|null} id
 * @returns {Set<string>}
 */
export function ancestry(parents, id) {
  const path = new Set();
  for (let at = id ?? undefined; at !== undefined && !path.has(at); at = parents.get(at))
    path.add(at);
  return path;
}

/**
 * The generation that undo shows: the last on the trail; without a trail (after a link was opened)
 * the one that this was bred from, or the one before it.
 * @param {Trail} trail
 * @param {Descent} descent
 * @param {string|null} shown
 * @returns {string|null}
 */
export function undoTarget(trail, { inOrder, known, parents }, shown) {
  const back = trail.past.findLast((id) => id !== shown && known.has(id));
  if (back !== undefined) return back;
  const at = inOrder.findIndex((generation) => generation.id === shown);
  if (at < 0) return null;
  return parents.get(inOrder[at].id) ?? inOrder[at - 1]?.id ?? null;
}

/**
 * The generation that redo shows: the next on the trail, or the newest bred from this one.
 * @param {Trail} trail
 * @param {Descent} descent
 * @param {string|null} shown
 * @returns {string|null}
 */
export function redoTarget(trail, { inOrder, known, parents }, shown) {
  const forward = trail.future.findLast((id) => id !== shown && known.has(id));
  if (forward !== undefined) return forward;
  return inOrder.findLast((generation) => parents.get(generation.id) === shown)?.id ?? null;
}

/**
 * The trail after a step from `shown` to `target`. A step to the target of undo or redo counts as
 * undo or redo, so that the browser's own buttons agree with the page's.
 * @param {Trail} trail
 * @param {string|null} shown
 * @param {string} target
 * @param {"visit"|"undo"|"redo"} how
 * @returns {Trail}
 */
export function step(trail, shown, target, how) {
  if (shown === null || shown === target) return trail;
  if (how === "undo")
    return { past: without(trail.past, target), future: [...trail.future, shown] };
  if (how === "redo")
    return { past: [...trail.past, shown], future: without(trail.future, target) };
  return { past: [...trail.past, shown].slice(-500), future: [] };
}

/**
 * Drops the last occurrence of an id and all that follows.
 * @param {string[]} ids
 * @param {string} id
 */
function without(ids, id) {
  const at = ids.lastIndexOf(id);
  return at < 0 ? ids : ids.slice(0, at);
}

/**
 * Links of the strip between columns: a child beside its parent gets a line, another an arc below
 * the pictures.
 * @param {Descent} descent
 * @param {Set<string>} path ids to emphasise
 * @returns {{from: number, to: number, id: string, onPath: boolean}[]}
 */
export function links({ inOrder, parents }, path) {
  const column = new Map(inOrder.map((generation, at) => [generation.id, at]));
  const found = [];
  for (const [child, parent] of parents) {
    const from = column.get(parent);
    const to = column.get(child);
    if (from === undefined || to === undefined) continue;
    found.push({ from, to, id: child, onPath: path.has(child) && path.has(parent) });
  }
  return found;
}
