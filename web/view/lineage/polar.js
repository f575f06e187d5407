/**
 * The polar plot of a genome's reflectance, with its options.
 *
 * @import { Curve, Plane } from "../../model.js"
 * @import { Axis } from "../../lineage/polar.js"
 */
import { axisFor, pathOf, peakOf, pointAt, radiusOf, valuesOf } from "../../lineage/polar.js";
import { lineageStore } from "../../lineage/store.js";
import { amount, decade } from "../../page/format.js";
import { Choice } from "../control.js";
import { html } from "../html.js";

/** Radius of the outermost ring; labels go outside. */
const RIM = 100;
const SPOKES_DEG = [-60, -30, 0, 30, 60];
const COLORS = [
  { value: "luminance", name: "luminance" },
  { value: "r", name: "red" },
  { value: "g", name: "green" },
  { value: "b", name: "blue" },
];

/** @param {number} theta_deg @param {number} radius */
const at = (theta_deg, radius) => pointAt(theta_deg, radius).map((one) => one.toFixed(2)).join(" ");

/** @param {{axis: Axis}} props */
function Rings({ axis }) {
  /** @param {number} value */
  const label = (value) => (axis.log ? decade(value) : amount(value));
  return html`
    <g class="rings">
      <path d=${`M${-RIM} 0H${RIM}`} />
      ${SPOKES_DEG.map((deg) => html`<path key=${deg} d=${`M0 0L${at(deg, RIM)}`} />`)}
      ${axis.rings.map((value) => {
        const radius = RIM * radiusOf(axis, value);
        return html`<path key=${value} d=${`M${-radius} 0A${radius} ${radius} 0 0 1 ${radius} 0`} /><text x=${radius} y="11">${label(value)}</text>`;
      })}
      <text x="0" y="11">${axis.log ? label(axis.low) : "0"}</text>
      ${SPOKES_DEG.map((deg) => {
        const [x, y] = pointAt(deg, RIM + 13);
        return html`<text key=${deg} x=${x} y=${y + 3}>${Math.abs(deg)}°</text>`;
      })}
    </g>
  `;
}

/**
 * Direction of the incident light: a wedge at the rim that points inward.
 * @param {{curve: Curve, order: number}} props
 */
const Incidence = ({ curve, order }) => {
  const theta = -curve.theta_i_deg;
  return html`<path class=${`incidence curve-${order}`} d=${`M${at(theta, RIM - 1)}L${at(theta - 2.2, RIM + 6)}L${at(theta + 2.2, RIM + 6)}Z`} />`;
};

/** @param {Plane} plane */
const planeName = (plane) => (plane.azimuth_deg === 0 ? "along u" : "across u");

/** @param {{planes: Plane[]}} props */
export function Polar({ planes }) {
  const { color, cosine, log } = lineageStore.polarOptions.value;
  const which = Math.min(lineageStore.polarOptions.value.plane, planes.length - 1);
  const plane = planes[which];
  if (!plane) return null;
  const curves = plane.curves.map((curve) => ({ curve, values: valuesOf(plane, curve, { color, cosine }) }));
  const axis = axisFor(curves.flatMap(({ values }) => values), log);
  const peaks = curves.map(({ curve, values }) => {
    const peak = peakOf(plane.theta_o_deg, values);
    return `${curve.theta_i_deg}°: ${peak ? `${amount(peak.value)} at ${peak.theta_deg}°` : "none"}`;
  });
  const name = `Polar plot of ${cosine ? "f cos θₒ" : "f"}, ${COLORS.find((one) => one.value === color)?.name}. Largest by incident angle: ${peaks.join("; ")}.`;
  /** @param {Partial<typeof lineageStore.polarOptions.value>} change */
  const turn = (change) => (lineageStore.polarOptions.value = { ...lineageStore.polarOptions.value, ...change });
  return html`
    <figure class="polar" data-testid="polar">
      <svg viewBox="-120 -120 240 136" role="img" aria-label=${name}>
        <${Rings} axis=${axis} />
        ${curves.map(({ curve, values }, order) => html`
          <g key=${curve.theta_i_deg}><path class=${`curve curve-${order}`} d=${pathOf(plane.theta_o_deg, values, axis, RIM)} /><${Incidence} curve=${curve} order=${order} /></g>
        `)}
      </svg>
      <figcaption class="legend">
        <span>light from</span>
        ${curves.map(({ curve }, order) => html`<span key=${curve.theta_i_deg} class=${`curve-${order}`}><svg viewBox="0 0 18 4" aria-hidden="true"><path class="curve" d="M0 2H18" /></svg> ${curve.theta_i_deg}°</span>`)}
      </figcaption>
      <div class="choices">
        ${planes.length > 1 && html`<${Choice} id="polar-plane" name="Plane" value=${String(which)} options=${planes.map((one, index) => ({ value: String(index), name: planeName(one) }))} onInput=${(/** @type {string} */ to) => turn({ plane: Number(to) })} />`}
        <${Choice} id="polar-quantity" name="Quantity" value=${cosine ? "cos" : "f"} options=${[{ value: "f", name: "f" }, { value: "cos", name: "f cos θₒ", title: "Times the cosine of the outgoing angle" }]} onInput=${(/** @type {string} */ to) => turn({ cosine: to === "cos" })} />
        <${Choice} id="polar-scale" name="Scale" value=${log ? "log" : "linear"} options=${[{ value: "linear", name: "linear" }, { value: "log", name: "log" }]} onInput=${(/** @type {string} */ to) => turn({ log: to === "log" })} />
        <${Choice} id="polar-color" name="Colour" value=${color} options=${COLORS} onInput=${(/** @type {any} */ to) => turn({ color: to })} />
      </div>
    </figure>
  `;
}
