/** Steering in the left pane: chips for the properties that children keep or change. */
import { lineageStore } from "../../lineage/store.js";
import { STEERS, noSteerInWords, withSteer } from "../../lineage/steer.js";
import { clearProblems } from "../../page/problem.js";
import { Switch } from "../control.js";
import { html } from "../html.js";
import { ProblemBox } from "../problem.js";

/** @param {import("../../model.js").Steer} word @param {boolean} on */
function turn(word, on) {
  clearProblems("steer");
  const knobs = lineageStore.knobs.value;
  lineageStore.knobs.value = { ...knobs, steer: withSteer(knobs.steer, word, on) };
}

export function Steering() {
  const { steer, homogeneous } = lineageStore.knobs.value;
  const genome = lineageStore.centreGenome.value;
  return html`
    <div class="steering" role="group" aria-labelledby="steer-title" data-testid="steering">
      <p class="small" id="steer-title">Steer the next brood</p>
      <div class="chips">
        ${STEERS.map(({ word, name, title }) => {
          const on = steer.includes(word);
          const reason = noSteerInWords(word, { homogeneous, genome });
          return html`<${Switch} key=${word} id=${`steer-${word}`} name=${name} on=${on} disabled=${reason !== "" && !on} title=${reason || title} onInput=${(/** @type {boolean} */ to) => turn(word, to)} />`;
        })}
      </div>
      <${ProblemBox} place="steer" />
      <p class="small" data-testid="steer-note">${lineageStore.painted.value ? "Painted materials are not steered: lock effects instead." : "Compared with the parent; random broods are not steered."}</p>
    </div>
  `;
}
