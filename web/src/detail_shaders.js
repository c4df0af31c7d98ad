// Both displacement maps and the reflectance, evaluated on the GPU (Ma et al. 2008, eq. 1 and 3).
const COMMON = `
precision highp float; precision highp int; precision highp sampler2DArray; precision highp sampler2D;
// eq. 1 with coefficients (d1^2, d2^2, d1 d2, d1, d2, 1)
// and after them the least and the greatest that it comes to in training
float polynomial(vec2 d, vec4 a, vec4 b) { return clamp((a.x*d.x + a.z*d.y + a.w)*d.x + (a.y*d.y + b.x)*d.y + b.y, b.z, b.w); }
float[6] powers(vec2 d) { return float[](d.x*d.x, d.y*d.y, d.x*d.y, d.x, d.y, 1.0); }
`;

export const detailVertex = (D) => `${COMMON}
in vec3 place;                        // triangle of the coarse mesh, two barycentric weights
in vec2 uv;
in float kind;                        // 0: detail; 1: plain skin at the rims; 2: an eyeball
uniform sampler2DArray modes;         // layers: rest and modes of the position, then of dP/du, then of dP/dv
uniform sampler2DArray coefficients;  // of the medium map, six layers of (u, v, n), then least and greatest
uniform sampler2D forms;              // 3 texels a triangle: d1 and d2 as quadratic forms in the weights
uniform float amount[${D.modes}];
uniform mat4 projectionMatrix, viewMatrix;
uniform float medium;
uniform int readback;                 // 0: a picture; 1: places and heights, 2: albedo, a texel a vertex
out vec3 spot, normal; out vec2 at, d; out float part;
vec3 sum(int first) {
  ivec2 texel = ivec2(gl_VertexID % ${D.width}, gl_VertexID / ${D.width});
  vec3 total = texelFetch(modes, ivec3(texel, first), 0).xyz;
  for (int i = 0; i < ${D.modes}; i++) total += amount[i] * texelFetch(modes, ivec3(texel, first + 1 + i), 0).xyz;
  return total;
}
void main() {
  vec3 shell = sum(0), n = normalize(cross(sum(${D.modes + 1}), sum(${2 * D.modes + 2})));
  vec3 u = sum(${D.modes + 1}); u = normalize(u - dot(u, n) * n);
  int triangle = int(place.x + 0.5);
  float a = place.y, b = place.z, c = 1.0 - a - b;
  vec4 f = texelFetch(forms, ivec2(0, triangle), 0), g = texelFetch(forms, ivec2(1, triangle), 0),
       h = texelFetch(forms, ivec2(2, triangle), 0);
  d.x = f.x*a*a + f.y*b*b + f.z*c*c + f.w*a*b + g.x*a*c + g.y*b*c;
  d.y = g.z*a*a + g.w*b*b + h.x*c*c + h.y*a*b + h.z*a*c + h.w*b*c;
  ivec2 texel = ivec2(gl_VertexID % ${D.width}, gl_VertexID / ${D.width});
  float power[6] = powers(d);
  vec3 offset = vec3(0);
  for (int m = 0; m < 6; m++) offset += power[m] * texelFetch(coefficients, ivec3(texel, m), 0).xyz;
  offset = clamp(offset, texelFetch(coefficients, ivec3(texel, 6), 0).xyz, texelFetch(coefficients, ivec3(texel, 7), 0).xyz);
  spot = shell + medium * (offset.x * u + offset.y * cross(n, u) + offset.z * n);
  normal = n; at = uv; part = kind;
  gl_Position = projectionMatrix * viewMatrix * vec4(spot, 1);
  if (readback > 0) {
    gl_Position = vec4(2.0 * (vec2(texel) + 0.5) / vec2(${D.width}, ${D.rows}) - 1.0, 0, 1);
    gl_PointSize = 1.0;
  }
}`;

export const detailFragment = `${COMMON}
in vec3 spot, normal; in vec2 at, d; in float part;
uniform sampler2D fine4, fine2, medium4, medium2;
uniform sampler2DArray reflectance;   // six layers of linear (r, g, b), then the least and greatest
uniform float fine, medium, light;
uniform bool fields, colours;
uniform int readback;
uniform mat4 viewMatrix;
layout(location = 0) out vec4 color;
vec3 albedo(vec2 st) {
  if (!colours) return vec3(0.62, 0.42, 0.34);
  float power[6] = powers(d);
  vec3 total = vec3(0);
  for (int m = 0; m < 6; m++) total += power[m] * texture(reflectance, vec3(st, float(m))).rgb;
  total = clamp(total, texture(reflectance, vec3(st, 6.0)).rgb, texture(reflectance, vec3(st, 7.0)).rgb);
  return clamp(total, 0.0, 1.0);
}
// Looking straight ahead, out of the face: pupil, iris and white by the distance from the axis, in radii of the ball.
vec3 eye(vec3 n) {
  float off = length(n.xy) + (n.z < 0.0 ? 1.0 : 0.0);
  return mix(vec3(0.01), mix(vec3(0.11, 0.06, 0.03), vec3(0.62, 0.58, 0.55), smoothstep(0.46, 0.5, off)), smoothstep(0.18, 0.21, off));
}
void main() {
  vec2 st = vec2(at.x, 1.0 - at.y);
  float height = polynomial(d, texture(fine4, st), texture(fine2, st));
  if (readback > 0) { color = readback == 1 ? vec4(spot, height) : vec4(albedo(st), 1); return; }
  float relief = part > 0.0 ? 0.0 : fine * height + medium * polynomial(d, texture(medium4, st), texture(medium2, st));
  vec3 px = dFdx(spot), py = dFdy(spot), n = normalize(normal);
  vec3 across = cross(py, n), up = cross(n, px);
  float area = dot(px, across);
  n = normalize(abs(area) * n - sign(area) * (dFdx(relief) * across + dFdy(relief) * up)); // Mikkelsen 2010
  n = mat3(viewMatrix) * n;
  vec3 lamp = normalize(vec3(sin(light), 0.5, cos(light))), half_way = normalize(lamp + vec3(0, 0, 1));
  vec3 skin = part > 1.5 ? eye(normalize(normal)) : fields ? vec3(0.5) + vec3(d, -d.x) * 0.25 : albedo(st);
  float shade = max(dot(n, lamp), 0.0), gloss = pow(max(dot(n, half_way), 0.0), 24.0);
  vec3 lit = skin * (0.22 + 0.25 * max(dot(n, vec3(-0.8, 0.1, 0.5)), 0.0) + 0.85 * shade) + 0.12 * gloss;
  color = vec4(pow(lit, vec3(1.0 / 2.2)), 1);
}`;
