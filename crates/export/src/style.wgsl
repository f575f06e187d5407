Helpers of exported styles: what a style reads of a point and of a light, from directions and the
derivatives of a fragment shader. style.rs prints the structures. The text above the first mark is
not exported.
// @style
// Length of the gradient of a value over a pixel, at most 1.
fn styled_step(value: f32) -> f32 {
  return min(length(vec2f(dpdx(value), dpdy(value))), 1.0);
}

// The point of a fragment. e: direction to the eye; n: normal; x: tangent along u; y: n cross x;
// all unit and in one space. depth: 0 one radius in front of the object's centre, 1 one radius
// behind it; uv: texture coordinates.
fn styled_point(e: vec3f, n: vec3f, x: vec3f, y: vec3f, depth: f32, uv: vec2f) -> StyledPoint {
  let facing: f32 = dot(n, e);
  let eye: vec3f = vec3f(dot(e, x), dot(e, y), facing);
  return StyledPoint(max(facing, 0.0), depth, styled_step(facing), styled_step(depth), eye, uv);
}

// A light at a fragment. l: direction to the light; color: its irradiance over the largest channel
// of all lights, each channel 0 to 1; visibility: 1 where nothing occludes it, 0 in its shadow; the
// others as for the point.
fn styled_light(l: vec3f, color: vec3f, visibility: f32, e: vec3f, n: vec3f, x: vec3f, y: vec3f) -> StyledLight {
  let cosine: f32 = dot(n, l);
  let mirror: f32 = 2.0 * dot(n, e) * cosine - dot(e, l);
  let direction: vec3f = vec3f(dot(l, x), dot(l, y), cosine);
  return StyledLight(cosine, mirror, visibility, color, styled_step(cosine), styled_step(mirror), direction);
}

