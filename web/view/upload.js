/** Progress of an upload, and a button that stops it. */
import { bytesInWords } from "../page/format.js";
import { html } from "./html.js";

/**
 * @param {{now: import("../model.js").Upload|null|undefined, stop: () => void, id: string}} props
 */
export function UploadProgress({ now, stop, id }) {
  if (!now) return null;
  const sent = now.sent >= now.whole;
  return html`
    <div class="sending" data-testid=${id}>
      <progress max="1" value=${sent ? undefined : now.sent / now.whole} aria-label=${sent ? "The server is reading it" : "Upload"}></progress>
      <span class="small">${sent ? "The server is reading it …" : `${bytesInWords(now.sent)} of ${bytesInWords(now.whole)} sent`}</span>
      <button type="button" data-testid=${`${id}-stop`} onClick=${stop}>Cancel</button>
    </div>
  `;
}
