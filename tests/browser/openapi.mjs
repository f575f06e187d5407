// Checks openapi.json, or the file named as argument, against OpenAPI 3.1: the structure of all
// objects, references, ids of operations, parameters of paths, and examples. Prints every problem
// with its place.

import { readFile } from "node:fs/promises";
import { fileURLToPath } from "node:url";
import {
  BaseResolver,
  createConfig,
  lintDocument,
  makeDocumentFromString,
} from "@redocly/openapi-core";

const RULES = [
  "struct",
  "no-unresolved-refs",
  "operation-operationId-unique",
  "operation-operationId-url-safe",
  "operation-parameters-unique",
  "operation-2xx-response",
  "path-parameters-defined",
  "path-declaration-must-exist",
  "path-not-include-query",
  "no-identical-paths",
  "no-schema-type-mismatch",
  "no-enum-type-mismatch",
  "no-required-schema-properties-undefined",
  "no-invalid-schema-examples",
  "no-invalid-media-type-examples",
  "no-invalid-parameter-examples",
  "spec-components-invalid-map-name",
];

const file = process.argv[2] ?? fileURLToPath(new URL("../../openapi.json", import.meta.url));
const { styleguide: config } = await createConfig({
  rules: Object.fromEntries(RULES.map((rule) => [rule, "error"])),
});
const document = makeDocumentFromString(await readFile(file, "utf8"), file);
const { openapi, paths } = document.parsed;
const problems = await lintDocument({ document, externalRefResolver: new BaseResolver(), config });
for (const { ruleId, message, location } of problems) {
  console.error(`${location[0].pointer ?? "#/"}: ${message} (${ruleId})`);
}
if (!openapi?.startsWith("3.1.")) {
  console.error(`openapi must be 3.1, got ${openapi}`);
  process.exitCode = 1;
} else if (problems.length > 0) {
  console.error(`${file} is not valid OpenAPI 3.1: ${problems.length} problems`);
  process.exitCode = 1;
} else {
  console.log(`openapi.json: valid OpenAPI ${openapi}, ${Object.keys(paths).length} paths`);
}
