/**
 * A link to a file, with the progress of its download.
 *
 * @import { Place } from "../model.js"
 */
import { download } from "../page/download.js";
import { bytesInWords } from "../page/format.js";
import { pageStore } from "../page/store.js";
import { html } from "./html.js";

/**
 * @param {{path: () => string, name: string, text: string, place: Place, id: string, label?:
 *   string, button?: boolean, accept?: string}} props `path`: read at the click, because the light
 *   may move; `name`: of the file; `accept`: media type; `label`: the whole name, where `text`
 *   alone says too little
 */
export function Download({ path, name, text, place, id, label, button = false, accept }) {
  const now = pageStore.downloads.value.get(name);
  /** @param {MouseEvent} event */
  const start = (event) => {
    event.preventDefault();
    void download(path(), name, place, accept);
  };
  if (!now) return html`<a class=${button ? "button" : ""} download=${name} href=${path()} aria-label=${label} title=${name} data-testid=${id} onClick=${start}>${text}</a>`;
  return html`
    <span class="download" data-testid=${`${id}-progress`}>
      <progress max="1" value=${now.whole ? now.received / now.whole : undefined} aria-label=${`Download of ${name}`}></progress>
      <span class="small">${now.received > 0 ? bytesInWords(now.received) : "The server is making it …"}</span>
      <button type="button" onClick=${now.stop}>Cancel</button>
    </span>
  `;
}
