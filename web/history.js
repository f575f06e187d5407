/**
 * The order of generations: who came from whom, undo and redo, and the arcs of the strip. Pure functions on plain values;
 * no network, no drawing, and no way to lose a generation, for nothing here removes one.
 *
 * @import { Generation, Trail } from "./types.js"
 */

/**
 * @typedef {{inOrder: Generation[], known: Set<string>, parents: Map<string, string>}} Descent
 *   Generations by index, their ids, and for each the one it was bred from.
 */

/**
 * @param {Generation[]} inOrder by index
 * @returns {Descent}
 */
export function descentOf(inOrder) {
  return { inOrder, known: new Set(inOrder.map((generation) => generation.id)), parents: parentGenerations(inOrder) };
}

/**
 * Which generation each generation was bred from: the one where its first parent was born. Roots have none.
 * @param {Generation[]} inOrder by index
 * @returns {Map<string, string>}
 */
export function parentGenerations(inOrder) {
  const born = new Map();
  const parents = new Map();
  for (const generation of inOrder) {
    const first = generation.parents[0];
    const from = first === undefined ? undefined : born.get(first);
    if (from !== undefined) parents.set(generation.id, from);
    for (const individual of generation.individuals) {
      born.set(individual.id, generation.id);
      // A parent may be named by its genome; the first to carry it is meant.
      if (!born.has(individual.hash)) born.set(individual.hash, generation.id);
    }
  }
  return parents;
}

/**
 * A generation and all it came from.
 * @param {Map<string, string>} parents
 * @param {string|null} id
 * @returns {Set<string>}
 */
export function ancestry(parents, id) {
  const path = new Set();
  for (let at = id ?? undefined; at !== undefined && !path.has(at); at = parents.get(at)) path.add(at);
  return path;
}

/**
 * Where undo leads: back along the trail; where there is none (a link was opened), to the generation that this one was
 * bred from, or to the one before it.
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
 * Where redo leads: forward along the trail, or to the newest generation bred from this one.
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
 * The trail after a step from `shown` to `target`. A step to where undo or redo lead counts as undo or redo, so that the
 * browser's own buttons agree with the page's.
 * @param {Trail} trail
 * @param {string|null} shown
 * @param {string} target
 * @param {"visit"|"undo"|"redo"} how
 * @returns {Trail}
 */
export function step(trail, shown, target, how) {
  if (shown === null || shown === target) return trail;
  if (how === "undo") return { past: without(trail.past, target), future: [...trail.future, shown] };
  if (how === "redo") return { past: [...trail.past, shown], future: without(trail.future, target) };
  return { past: [...trail.past, shown].slice(-500), future: [] };
}

/**
 * Drops everything from the last occurrence of an id on.
 * @param {string[]} ids
 * @param {string} id
 */
function without(ids, id) {
  const at = ids.lastIndexOf(id);
  return at < 0 ? ids : ids.slice(0, at);
}

/**
 * Links of the strip between columns: a child beside its parent gets a line, another an arc below the pictures.
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
