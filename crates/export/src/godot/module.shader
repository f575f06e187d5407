shader_type spatial;
render_mode ambient_light_disabled;

// A material bred by brood, for Godot 3 and its renderer GLES3: @PROPERTIES@.
// Program @PROGRAM@, @OPERATIONS@ operations.
//
// Save it in a project and choose it as the shader of a ShaderMaterial. Each light of the scene
// adds f cos times its colour; a white diffuse surface, f = 1 / pi, is as bright as Godot's own.
// There is no light from the surroundings. The mesh needs normals and tangents (in the import of a
// mesh: Ensure Tangents), and texture coordinates if the material has a texture or bumps.

// Every product and sum is rounded separately. brood_zero must be 0: because compilers do not know
// its value, they cannot fuse operations across brood_hold.
uniform int brood_zero = 0;
varying vec3 brood_tangent;
varying float brood_sign;

@CODE@

void vertex() {
  brood_tangent = (MODELVIEW_MATRIX * vec4(TANGENT, 0.0)).xyz;
  brood_sign = (dot(cross(NORMAL, TANGENT), BINORMAL) < 0.0) ? -1.0 : 1.0;
}

void light() {
  vec3 n = normalize(NORMAL);
  float cosine = dot(n, LIGHT);
  if (cosine > 0.0) {
    // The eye is at least 1e-4 above the surface.
    vec3 eye = normalize(VIEW + n * max(1e-4 - dot(n, VIEW), 0.0));
    // Without tangents, any direction along the surface.
    vec3 along = brood_tangent - n * dot(n, brood_tangent);
    vec3 any = (abs(n.x) < 0.5) ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 1.0, 0.0);
    vec3 x = normalize((dot(along, along) > 0.0) ? along : (any - n * dot(n, any)));
    // v grows downwards in Godot, upwards in the code above.
    vec3 f = evolved(LIGHT, eye, n, x, @ACROSS@, vec2(UV.x, 1.0 - UV.y));
    SPECULAR_LIGHT += f * cosine * ATTENUATION * LIGHT_COLOR;
  }
}
