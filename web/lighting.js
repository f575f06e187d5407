/**
 * The scene's first light as the left pane turns it: read, held while a hand is on it, and left to the server. Owns what is
 * between the control and the scene; the arithmetic is light_color.js's, the order of changes scene.js's.
 *
 * @import { Lamp } from "./light_color.js"
 * @import { Scene } from "./types.js"
 */
import { computed, effect, signal, untracked } from "./vendor/signals-core.js";
import { extentOf, extents } from "./extents.js";
import { PLAIN, intensityOf, lampOf, plainStrength, strengthField } from "./light_color.js";
import { guarded } from "./lineage.js";
import { ready } from "./pictures.js";
import { changeScene } from "./scene.js";
import { held, knobsOpen, wishedScene } from "./state.js";

/** @template T @typedef {import("./vendor/signals-core.js").Signal<T>} Signal */

/** The colour as it was picked and the strength, while they are held. @type {Signal<Lamp|null>} */
const inHand = signal(null);

/** @param {Scene|null} scene @returns {number|null} */
function plainOf(scene) {
  const light = scene?.lights?.[0];
  const extent = scene && extents.value.get(scene.mesh);
  return light && extent && strengthField(light) ? plainStrength(light, extent) : null;
}

/** Whether the controls can change anything yet. */
export const lampKnown = computed(() => plainOf(wishedScene.value) !== null);

/** What the controls show; null where the light is dark. @type {Signal<Lamp|null>} */
export const lamp = computed(() => {
  if (inHand.value) return inHand.value;
  const plain = plainOf(wishedScene.value);
  const light = wishedScene.value?.lights?.[0];
  const field = light && strengthField(light);
  return plain === null || !field ? PLAIN : lampOf(light[field], plain);
});

/** Turns the light while a hand is on a control; what is drawn live follows. @param {Partial<Lamp>} change */
export function turnLamp(change) {
  const scene = wishedScene.value;
  const plain = plainOf(scene);
  if (!scene?.lights || plain === null) return;
  const wanted = { ...(lamp.value ?? PLAIN), ...change };
  const [first, ...others] = scene.lights;
  const field = strengthField(first);
  if (!field) return;
  inHand.value = wanted;
  held.value = { lights: [{ ...first, [field]: intensityOf(wanted, plain) }, ...others] };
}

/** Has everything drawn under the light as it was left. */
export function leaveLamp() {
  const left = held.value;
  if (!left) return;
  void changeScene("light", () => left).finally(() => {
    if (held.value !== left) return;
    held.value = null;
    inHand.value = null;
  });
}

/** Learns what the strength is counted against, once the pictures are there. */
export function watchLighting() {
  return effect(() => {
    const mesh = wishedScene.value?.mesh;
    if (!mesh || !knobsOpen.value || ready.value === null || extents.value.has(mesh)) return;
    // What is told of a failure must not ask again.
    untracked(() => void guarded("light", async () => {
      await extentOf(mesh);
    }));
  });
}
