/** Pictures beside the frames: history, favourites, comparisons, lists. */
import { pictureFailed, pictureLoaded } from "../lineage/pictures.js";
import { lineageStore } from "../lineage/store.js";
import { pictureSource } from "../page/distance.js";
import { html } from "./html.js";

/**
 * A picture of the server, requested again until it has loaded.
 * @param {{url: string, alt?: string, side?: number, lazy?: boolean, name?: string, onFailed?:
 *   (often: boolean) => void}} props `side`: in CSS pixels; `name`: class; `onFailed`: called at
 *   each failure, with true once the picture counts as failed
 */
export function ServerPicture({ url, alt = "", side, lazy = false, name, onFailed }) {
  const tried = lineageStore.pictureRetries.value.get(url) ?? 0;
  const failed = () => {
    const often = pictureFailed(url);
    onFailed?.(often);
  };
  return html`<img key=${`${url} ${tried}`} class=${name} src=${pictureSource(url)} alt=${alt} width=${side} height=${side} loading=${lazy ? "lazy" : undefined} draggable=${false} onLoad=${() => pictureLoaded(url)} onError=${failed} />`;
}
