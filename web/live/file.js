/** Heads of the files that workers make for live drawing. */

/**
 * The numbers in the head of a file, which follow its magic word and its version.
 * @param {ArrayBuffer} bytes
 * @param {{magic: string, version: number, name: string, count: number}} expected `name`: of what
 *   the file holds; `count`: of numbers
 * @returns {number[]}
 */
export function readHead(bytes, { magic, version, name, count }) {
  const file = new DataView(bytes);
  const found = String.fromCharCode(...new Uint8Array(bytes, 0, 8));
  const [own, ...numbers] = Array.from({ length: 1 + count }, (_, k) =>
    file.getUint32(8 + 4 * k, true),
  );
  if (found !== magic || own !== version)
    throw new Error(`the ${name} are of another version than the page`);
  return numbers;
}
