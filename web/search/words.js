/**
 * Searches and targets in words: states, budgets, times, kinds of files.
 *
 * @import { Budget, Found, JobState, Target, TargetKind } from "../model.js"
 */
import { amount } from "../page/format.js";

/**
 * Kinds of files that hold a material, with their extensions.
 * @type {{value: TargetKind, name: string, ends: RegExp}[]}
 */
export const KINDS = [
  { value: "samples", name: "samples (.csv)", ends: /\.csv$/i },
  { value: "slice", name: "image slice (.exr)", ends: /\.exr$/i },
  { value: "merl", name: "MERL table (.binary)", ends: /\.binary$/i },
  { value: "rgl", name: "RGL measurement (.bsdf)", ends: /\.bsdf$/i },
  { value: "cornell", name: "goniometer text (.brdf)", ends: /\.brdf$/i },
  {
    value: "image",
    name: "picture of a known scene (.png .jpg .hdr .exr)",
    ends: /\.(png|jpe?g|hdr)$/i,
  },
];

/** Kind of a file by its name; empty if unknown. @param {string} name @returns {TargetKind|""} */
export const kindOf = (name) => KINDS.find(({ ends }) => ends.test(name))?.value ?? "";

/** @param {TargetKind} kind */
export const kindInWords = (kind) =>
  (KINDS.find(({ value }) => value === kind)?.name ?? kind).replace(/ \(.*$/, "");

/** @type {Record<JobState, string>} */
const STATES = {
  queued: "queued",
  running: "searching",
  paused: "paused",
  succeeded: "done",
  failed: "failed",
  cancelled: "cancelled",
};

/** @param {JobState} state */
export const stateInWords = (state) => STATES[state] ?? state;

/** True if a search has ended. @param {{state: JobState}} of */
export const hasEnded = ({ state }) =>
  state === "succeeded" || state === "failed" || state === "cancelled";

/** Possible actions on a search in its state. @param {{state: JobState}} of */
export const canBe = (of) => ({
  paused: of.state === "queued" || of.state === "running",
  resumed: of.state === "paused",
  cancelled: !hasEnded(of),
});

/** @type {Record<string, string>} */
const REASONS = { worker_lost: "Each worker that ran this search stopped unexpectedly." };

/** Reason of a failure. @param {string|null|undefined} reason */
export const reasonInWords = (reason) =>
  reason ? (REASONS[reason] ?? reason) : "The server gave no reason.";

/** A whole number with its noun. @param {number} of @param {string} noun */
export const counted = (of, noun) => `${of.toLocaleString("en")} ${noun}${of === 1 ? "" : "s"}`;

/** "0.4 s", "25 s", "3 min 5 s", "2 h 10 min". @param {number} seconds */
export function duration(seconds) {
  if (seconds < 10 && !Number.isInteger(seconds)) return `${seconds.toFixed(1)} s`;
  const whole = Math.round(seconds);
  if (whole < 60) return `${whole} s`;
  const [days, hours, minutes] = [
    Math.floor(whole / 86400),
    Math.floor(whole / 3600) % 24,
    Math.floor(whole / 60) % 60,
  ];
  const parts =
    days > 0
      ? [
          [days, "d"],
          [hours, "h"],
        ]
      : hours > 0
        ? [
            [hours, "h"],
            [minutes, "min"],
          ]
        : [
            [minutes, "min"],
            [whole % 60, "s"],
          ];
  return parts
    .filter(([value]) => value !== 0)
    .map(([value, unit]) => `${value} ${unit}`)
    .join(" ");
}

/** @param {Budget} of */
export function budgetInWords(of) {
  if (of.seconds) return duration(of.seconds);
  if (of.generations) return counted(of.generations, "generation");
  return counted(of.evaluations ?? 0, "evaluation");
}

/**
 * An error with three digits; very small ones as powers of ten.
 * @param {number|null|undefined} of
 */
export const errorInWords = (of) =>
  typeof of === "number" && Number.isFinite(of)
    ? of >= 1e-4
      ? String(Number(of.toPrecision(3)))
      : amount(of)
    : "–";

/**
 * Reason why the best result has not the least held-out error, in words; empty where it has.
 * @param {Found[]} front the best first
 */
export function choiceInWords(front) {
  const [best, ...others] = front;
  const lower = others.filter(({ e_log }) => e_log < best.e_log).length;
  if (lower === 0) return "";
  return `The best is chosen on fitted samples, because held-out samples only check the choice: ${lower === 1 ? "one other result has" : `${lower} other results have`} a lower held-out error.`;
}

/** Name of a target for people. @param {Target} of */
export const nameOfTarget = (of) =>
  of.name || `${kindInWords(of.kind)} of ${new Date(of.created_ms).toLocaleString()}`;
