/** An image of the scene: a button that opens a file, and a small picture. */
import { PICTURES } from "../lineage/painting.js";
import { html } from "./html.js";
import { Thumbnail } from "./lineage/images.js";

/**
 * @param {{id: string, name: string, of: string, image: string|null, title: string, onFile: (file:
 *   File) => void}} props `name`: of the image in words; `of`: the part that it belongs to, in
 *   words
 */
export function ImageField({ id, name, of, image, title, onFile }) {
  /** @param {Event} event */
  const read = (event) => {
    const input = /** @type {HTMLInputElement} */ (event.target);
    const [file] = input.files ?? [];
    if (file) onFile(file);
    // The same file may be chosen again.
    input.value = "";
  };
  const words = image ? `Replace the ${name}` : `Open a ${name}`;
  return html`
    ${image && html`<${Thumbnail} key=${image} image=${image} name=${`${name} of ${of}`} />`}
    <label class="button" title=${title}>
      <input type="file" accept=${PICTURES} data-testid=${id} aria-label=${`${words} of ${of}`} onChange=${read} />
      <span>${image ? "Replace" : words}</span>
    </label>
  `;
}
