// Structure of the page: no circles of imports, few files at the root, signals only in stores.

import assert from "node:assert/strict";
import { existsSync, readFileSync, readdirSync } from "node:fs";
import { dirname, join, relative } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";

const root = fileURLToPath(new URL("..", import.meta.url));
const MOST_AT_ROOT = 10;
/** Folders that hold no modules of the page. */
const OTHERS = ["node_modules", "presets", "style", "test", "vendor"];

/** @param {string} folder @returns {string[]} paths of its modules */
function modulesIn(folder) {
  return readdirSync(folder, { withFileTypes: true }).flatMap((entry) => {
    const path = join(folder, entry.name);
    if (entry.isDirectory()) return OTHERS.includes(entry.name) ? [] : modulesIn(path);
    return entry.name.endsWith(".js") ? [path] : [];
  });
}

/** Text of each module by its path. */
const modules = new Map(modulesIn(root).map((path) => [path, readFileSync(path, "utf8")]));

/**
 * Files that a module loads; imports of types are comments and do not count.
 * @param {string} path
 */
const importsOf = (path) =>
  [...modules.get(path).matchAll(/^(?:import|export)\b(?:[^;"=]*? from)? ?"(\.[^"]+)";/gm)].map(
    (found) => join(dirname(path), found[1]),
  );

/** First circle of imports as a list of paths; null if there is none. */
function circle() {
  const done = new Set();
  /** @param {string} path @param {string[]} way @returns {string[]|null} */
  const visit = (path, way) => {
    if (way.includes(path)) return [...way.slice(way.indexOf(path)), path];
    if (done.has(path)) return null;
    for (const to of importsOf(path).filter((one) => modules.has(one))) {
      const found = visit(to, [...way, path]);
      if (found) return found;
    }
    done.add(path);
    return null;
  };
  for (const path of modules.keys()) {
    const found = visit(path, []);
    if (found) return found.map((one) => relative(root, one));
  }
  return null;
}

test("modules have no circle of imports", () => {
  assert.ok(importsOf(join(root, "main.js")).length > 10, "imports are found");
  assert.equal(circle()?.join(" -> ") ?? "none", "none");
});

test("the root of the page has at most ten files", () => {
  const files = readdirSync(root, { withFileTypes: true }).filter((entry) => entry.isFile());
  assert.ok(files.length <= MOST_AT_ROOT, files.map(({ name }) => name).join(" "));
});

test("signals of modules are in stores", () => {
  const outside = [...modules]
    .filter(
      ([path, text]) =>
        !path.endsWith("/store.js") &&
        /^(?:export )?(?:const|let) .*= (?:signal|computed)\(/m.test(text),
    )
    .map(([path]) => relative(root, path));
  assert.deepEqual(outside, []);
});

test("every import of a module exists", () => {
  const missing = [...modules.keys()].flatMap((path) =>
    importsOf(path)
      .filter((to) => !existsSync(to))
      .map((to) => `${relative(root, path)}: ${to}`),
  );
  assert.deepEqual(missing, []);
});
