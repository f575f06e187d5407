/**
 * The `html` template tag: htm bound to preact. Loads the module that redraws each component when a
 * signal that it has read changes.
 */
import htm from "../vendor/htm.js";
import { h } from "../vendor/preact.js";
import "../vendor/signals.js";

export const html = htm.bind(h);
