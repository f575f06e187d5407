/** The page as a whole: bar, panes, stage, strip, and dialogs. */
import { lineageStore } from "../lineage/store.js";
import { pageStore } from "../page/store.js";
import { Bar } from "./bar.js";
import { Comparison } from "./compare/comparison.js";
import { Favourites } from "./favourites/favourites.js";
import { Frames } from "./frames.js";
import { Help } from "./help.js";
import { Hint, Mating, Others } from "./hint.js";
import { html } from "./html.js";
import { Knobs } from "./knobs.js";
import { Details } from "./lineage/details.js";
import { Inspector } from "./lineage/inspector.js";
import { Lineages } from "./lineage/lineages.js";
import { LockSign, TwinsWarning } from "./lineage/locks.js";
import { Presets } from "./lineage/presets.js";
import { Strip } from "./lineage/strip.js";
import { ProblemBox } from "./problem.js";
import { Searches } from "./search/searches.js";
import { TokenQuestion } from "./token_question.js";

const DropHint = () => pageStore.fileDragged.value && html`
  <div class="drop" aria-hidden="true"><p>Drop an OBJ file as the object, a .brood file to breed from, or ${lineageStore.painted.value ? "a picture to paint in its colours" : "measurements or pictures to search for"}</p></div>
`;

/** Messages for screen readers. */
const LiveRegion = () => html`<div class="unseen" role="status" aria-live="polite">${pageStore.announcement.value}</div>`;

/** Moves the focus past the bar and the knobs. @param {Event} event */
function skip(event) {
  event.preventDefault();
  const frame = document.querySelector(`[data-cell="${pageStore.focusedCell.value}"]`);
  if (frame instanceof HTMLElement) frame.focus();
}

export function App() {
  return html`
    <a class="skip" href="#frames" data-testid="skip" onClick=${skip}>Skip to the pictures</a>
    <${Bar} />
    <div class="middle">
      ${pageStore.knobsOpen.value && html`<${Knobs} />`}
      <main class="stage" aria-label="Brood">
        <div class="field"><${Frames} /></div>
        <${ProblemBox} place="stage" />
        <${LockSign} /><${TwinsWarning} />
        <${Others} />
        <${Hint} />
        <${Mating} />
      </main>
      ${pageStore.detailsOpen.value && html`<${Details} />`}
    </div>
    <${Strip} />
    <${Lineages} />
    <${Presets} />
    <${Searches} />
    <${Favourites} />
    <${Inspector} />
    <${Comparison} />
    <${Help} />
    <${TokenQuestion} />
    <${DropHint} />
    <${LiveRegion} />
  `;
}
