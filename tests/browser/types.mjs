// Generates web/types.d.ts, the types of the server's answers, from openapi.json. With --check,
// fails if the committed file differs instead of writing it.

import { readFile, writeFile } from "node:fs/promises";
import { fileURLToPath } from "node:url";
import openapiTS, { astToString } from "openapi-typescript";

const root = new URL("../../", import.meta.url);
const target = fileURLToPath(new URL("web/types.d.ts", root));
const HEAD = "// Generated from openapi.json by tests/browser/types.mjs; not edited by hand.\n\n";

const { openapi, info, components } = JSON.parse(
  await readFile(new URL("openapi.json", root), "utf8"),
);
// The page has its own list of routes, so only the schemas are used. It names the items of a list,
// not the list, whose schema repeats that of its items.
const used = Object.entries(components.schemas).filter(([name]) => !name.startsWith("Page_"));
const schemas = {
  openapi,
  info,
  paths: {},
  components: { schemas: Object.fromEntries(used) },
};
const made =
  HEAD + astToString(await openapiTS(schemas, { rootTypes: true, rootTypesNoSchemaPrefix: true }));

if (process.argv.includes("--check")) {
  const committed = await readFile(target, "utf8").catch(() => "");
  if (committed !== made) {
    console.error("web/types.d.ts does not match openapi.json: run node tests/browser/types.mjs");
    process.exitCode = 1;
  }
} else {
  await writeFile(target, made);
}
