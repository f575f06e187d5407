/**
 * Toon shapes: a BRDF under effects that paint what it reflects. Pure functions of a genome's text.
 */

/** Effects of a new toon shape: breeding changes its palette. */
const EFFECTS = [
  ".effect light",
  "palette #231a3a #8c3f5c #eda45f #fff0cf",
  "edges 0.14 0.42 0.8",
  "basis cubic",
  "feather 0.06",
  "by brdf",
  "from 0",
  "to 0.4",
  ".effect silhouette",
  "color #1a1020",
  "from 0.74",
  "to 0.82",
];

/**
 * Text of a BRDF's genome with effects that paint it: after its models, before its instructions.
 * Bumps are left out, because painted materials have none.
 * @param {string} text as the server writes it
 */
export function toonShape(text) {
  const all = text.trimEnd().split("\n");
  const lines = all.filter((line) => !line.startsWith(".bump "));
  const first = lines.findIndex((line) => /^[A-Z]/.test(line));
  const at = first < 0 ? lines.length : first;
  return [...lines.slice(0, at), ...EFFECTS, ...lines.slice(at), ""].join("\n");
}
