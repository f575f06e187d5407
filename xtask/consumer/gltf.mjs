// Validates glTF binaries: node gltf.mjs DIR. Prints one object of JSON: the number of errors of
// each file by its name, from Khronos's validator, and its version.
import { readFileSync, readdirSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join } from 'node:path';

const require = createRequire(new URL('../../tests/browser/package.json', import.meta.url));
const validator = require('gltf-validator');

const folder = process.argv[2];
const errors = {};
for (const name of readdirSync(folder).filter((name) => name.endsWith('.glb'))) {
  const report = await validator.validateBytes(new Uint8Array(readFileSync(join(folder, name))));
  errors[name] = report.issues.numErrors + report.issues.numWarnings;
}
console.log(JSON.stringify({ version: validator.version(), errors }));
