/** Generations in the store: those not used for long are reduced, and nothing shown is lost. */
import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";
import { compareStore } from "../compare/store.js";
import {
  clearGenerations, readGeneration, storeOutlines, storeRead,
} from "../lineage/generations.js";
import { birthOf, updateIndividual } from "../lineage/individuals.js";
import { centreOf, lineageStore } from "../lineage/store.js";

const COUNT = 1000;
const CHILDREN = 20;

/** Child `i<index>.<slot>` of generation `g<index>`. */
const individual = (index, slot, more = {}) => ({
  id: `i${index}.${slot}`,
  hash: `h${index}.${slot}`,
  slot,
  operator: "mutate",
  favourite: false,
  note: "",
  version: 1,
  ...more,
});

/** Generation `g<index>`, bred from child 7 of the one before. */
const generation = (index, more = {}) => ({
  id: `g${index}`,
  lineage: "l",
  index,
  parents: index > 0 ? [`i${index - 1}.7`] : [],
  centre: index > 0 ? individual(index - 1, 7) : null,
  individuals: Array.from({ length: CHILDREN }, (_, slot) => individual(index, slot)),
  ...more,
});

const chain = Array.from({ length: COUNT }, (_, index) => generation(index));
const of = (id) => lineageStore.generations.value.get(id);
const countOf = (id) => of(id).individuals.length;
const heldCount = () =>
  lineageStore.ordered.value.reduce((sum, { individuals }) => sum + individuals.length, 0);
/** Each of the chain is bred from the one before. */
const assertChain = () => {
  const { parents } = lineageStore.descent.value;
  for (let at = 1; at < COUNT; at += 1) assert.equal(parents.get(`g${at}`), `g${at - 1}`);
};

beforeEach(() => {
  lineageStore.lineage.value = /** @type {any} */ ({ id: "l", scene: "s" });
  lineageStore.shownId.value = null;
  compareStore.pinned.value = null;
  clearGenerations();
});

test("a list of generations and a thousand broods leave the same few individuals", () => {
  storeRead(chain, "s");
  const listed = heldCount();
  assert.ok(listed < 70 * CHILDREN, `${listed} individuals`);
  assertChain();
  clearGenerations();
  for (const made of chain) {
    storeRead([made], "s");
    lineageStore.shownId.value = made.id;
  }
  assert.equal(heldCount(), listed);
  assertChain();
  assert.equal(countOf("g999"), CHILDREN);
  assert.equal(countOf("g5"), 0);
});

test("the shown generation and what other parts of the page look up are kept", () => {
  const favourite = individual(2, 4, { favourite: true });
  const adopted = individual(3, 0, { operator: "adopt" });
  lineageStore.shownId.value = "g1";
  compareStore.pinned.value = /** @type {any} */ (individual(4, 9));
  const early = [
    ...chain.slice(0, 2),
    generation(2, { individuals: chain[2].individuals.with(4, favourite) }),
    generation(3, { individuals: [adopted] }),
  ];
  storeRead(early, "s");
  const centres = early.map(centreOf);
  for (const made of chain.slice(4)) storeRead([made], "s");
  assert.equal(countOf("g1"), CHILDREN);
  assert.deepEqual(of("g2").individuals, [favourite]);
  assert.deepEqual(of("g3").individuals, [adopted]);
  assert.deepEqual(of("g4").individuals.map(({ id }) => id), ["i4.9"]);
  // The strip shows the same pictures.
  assert.deepEqual(early.map(({ id }) => centreOf(of(id))), centres);
});

test("descent and births do not depend on what is held", () => {
  storeRead(chain.slice(0, 500), "s");
  // A brood with the parents of an early one, whose birth is known from that one's centre.
  storeRead([generation(500, { parents: ["i9.7"], centre: individual(9, 7) })], "s");
  assert.equal(of("g500").from, "g9");
  assert.equal(birthOf("i9.7").id, "g9");
  assert.equal(birthOf("i9.8"), null);
  // Another client's brood from a dropped individual is placed once its birth is read again.
  storeRead([generation(501, { parents: ["i20.3"], centre: individual(20, 3) })], "s");
  assert.equal(of("g501").from, undefined);
  storeRead([chain[20]], "s");
  assert.equal(of("g501").from, "g20");
  assert.equal(birthOf("i20.3").id, "g20");
});

test("a dropped generation is whole after it is read again, with its newer marks", async () => {
  storeRead(chain, "s");
  assert.equal(countOf("g30"), 0);
  const { fetch } = globalThis;
  const asked = [];
  globalThis.fetch = /** @type {any} */ (
    async (path) => {
      asked.push(path);
      return Response.json(chain[30]);
    }
  );
  try {
    await readGeneration("g30", "s");
  } finally {
    globalThis.fetch = fetch;
  }
  assert.deepEqual(asked, ["/v1/generations/g30"]);
  assert.equal(countOf("g30"), CHILDREN);
  updateIndividual("i30.2", { favourite: true, version: 2 });
  storeRead(chain, "s");
  assert.deepEqual(of("g30").individuals.map(({ id }) => id), ["i30.2"]);
  assert.ok(of("g30").individuals[0].favourite);
  assertChain();
});

/** Outline of a generation of the chain, as the server gives it. */
const outline = (index, more = {}) => ({
  id: `g${index}`,
  index,
  from: index > 0 ? `g${index - 1}` : undefined,
  centre: index > 0 ? individual(index - 1, 7) : null,
  individuals: index > 0 ? [] : [individual(0, 0)],
  ...more,
});

test("outlines give the whole history, and leave generations that were read as they are", () => {
  storeRead([generation(5, { parents: [] })], "s");
  storeOutlines(chain.map((_, index) => outline(index)));
  assert.equal(lineageStore.generations.value.size, COUNT);
  assert.equal(countOf("g5"), CHILDREN);
  assert.equal(countOf("g6"), 0);
  assert.equal(centreOf(of("g0")).id, "i0.0");
  const { parents } = lineageStore.descent.value;
  for (let at = 6; at < COUNT; at += 1) assert.equal(parents.get(`g${at}`), `g${at - 1}`);
  assert.equal(birthOf("i3.7"), of("g3"), "the centre of the next generation was born there");
});

test("outlines that are read again replace marks that another client took away", () => {
  storeOutlines([outline(0), outline(1, { individuals: [individual(1, 4, { favourite: true })] })]);
  assert.equal(countOf("g1"), 1);
  storeOutlines([outline(0), outline(1)]);
  assert.equal(countOf("g1"), 1, "known ones stay");
  storeOutlines([outline(0), outline(1)], true);
  assert.equal(countOf("g1"), 0);
});
