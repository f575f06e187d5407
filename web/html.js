/**
 * The `html` template tag: htm bound to preact. Owns the one place that names the two libraries together; knows nothing
 * of the page.
 */
import { h } from "./vendor/preact.js";
import htm from "./vendor/htm.js";

export const html = htm.bind(h);
