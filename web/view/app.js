/**
 * The page as a whole: bar, panes, stage, strip, and what lies over them. Owns the arrangement; each part draws itself.
 */
import { html } from "../html.js";
import { announcement, detailsOpen, fileOver, knobsOpen } from "../state.js";
import { Bar } from "./bar.js";
import { Comparison } from "./comparison.js";
import { Details } from "./details.js";
import { Frames } from "./frames.js";
import { Hint, Mating } from "./hint.js";
import { Inspector } from "./inspector.js";
import { Knobs } from "./knobs.js";
import { Lineages } from "./lineages.js";
import { LockSign } from "./locks.js";
import { Presets } from "./presets.js";
import { Searches } from "./searches.js";
import { Strip } from "./strip.js";
import { TokenQuestion } from "./token_question.js";
import { Trouble } from "./trouble.js";

export function App() {
  return html`
    <${Bar} />
    <div class="middle">
      ${knobsOpen.value && html`<${Knobs} />`}
      <main class="stage" aria-label="Brood">
        <div class="field"><${Frames} /></div>
        <${Trouble} place="stage" />
        <${LockSign} />
        <${Hint} />
        <${Mating} />
      </main>
      ${detailsOpen.value && html`<${Details} />`}
    </div>
    <${Strip} />
    <${Lineages} />
    <${Presets} />
    <${Searches} />
    <${Inspector} />
    <${Comparison} />
    <${TokenQuestion} />
    ${fileOver.value && html`<div class="drop" aria-hidden="true"><p>Drop an OBJ to breed on it, a .brood to breed from it, or measured samples or pictures to search for them</p></div>`}
    <div class="unseen" role="status" aria-live="polite">${announcement.value}</div>
  `;
}
