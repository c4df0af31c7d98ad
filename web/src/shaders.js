// GLSL: the passes that make a face's shape on the GPU, and how it is lit (the twin of mien.pictures.render).
export const WIDTH = 512; // of textures that hold one vertex a texel
export const MOST_BLENDED = 16; // captures whose textures are blended at one time

const COMMON = `
precision highp float; precision highp int; precision highp sampler2D; precision highp isampler2DArray;
ivec2 texel(int i) { return ivec2(i % ${WIDTH}, i / ${WIDTH}); }
`;

export const COVER = `${COMMON}
in vec3 position; out vec2 at;
void main() { at = position.xy; gl_Position = vec4(position.xy, 0.0, 1.0); }`;

// f = b0 + sum_k w_k m_k (b_k - b0), the shapes in use alone.
export const MORPH = `${COMMON}
uniform sampler2D neutral, used; uniform isampler2DArray deltas; uniform int count;
out vec4 made;
void main() {
  ivec2 here = ivec2(gl_FragCoord.xy);
  vec3 place = texelFetch(neutral, here, 0).xyz;
  for (int i = 0; i < count; i++) {
    vec2 shape = texelFetch(used, ivec2(i, 0), 0).xy;
    place += shape.y * vec3(texelFetch(deltas, ivec3(here, int(shape.x + 0.5)), 0).xyz);
  }
  made = vec4(place, 1.0);
}`;

// Loop's subdivision: each fine vertex is a sum of coarse ones.
export const SUBDIVIDE = `${COMMON}
uniform sampler2D places, spans, entries; out vec4 made;
void main() {
  vec2 span = texelFetch(spans, ivec2(gl_FragCoord.xy), 0).xy;
  vec3 place = vec3(0.0);
  int first = int(span.x + 0.5), last = first + int(span.y + 0.5);
  for (int i = first; i < last; i++) {
    vec2 entry = texelFetch(entries, texel(i), 0).xy;
    place += entry.y * texelFetch(places, texel(int(entry.x + 0.5)), 0).xyz;
  }
  made = vec4(place, 1.0);
}`;

// Area-weighted vertex normals of the moved places.
export const NORMALS = `${COMMON}
uniform sampler2D places, spans, entries; out vec4 made;
void main() {
  vec2 span = texelFetch(spans, ivec2(gl_FragCoord.xy), 0).xy;
  vec3 here = texelFetch(places, ivec2(gl_FragCoord.xy), 0).xyz, sum = vec3(0.0);
  int first = int(span.x + 0.5), last = first + int(span.y + 0.5);
  for (int i = first; i < last; i++) {
    vec2 entry = texelFetch(entries, texel(i), 0).xy;
    vec3 b = texelFetch(places, texel(int(entry.x + 0.5)), 0).xyz - here;
    sum += cross(b, texelFetch(places, texel(int(entry.y + 0.5)), 0).xyz - here);
  }
  float size = length(sum);
  made = vec4(size > 0.0 ? sum / size : vec3(0.0, 0.0, 1.0), 1.0);
}`;

const SURFACE = `${COMMON}
in float source;
uniform sampler2D places; uniform mat4 modelViewMatrix, projectionMatrix;
`;

// How deep the surface is, drawn first, so that what shades the face does so once a pixel.
export const DEPTH_VERTEX = `${SURFACE}
invariant gl_Position;
void main() {
  vec4 seen = modelViewMatrix * vec4(texelFetch(places, texel(int(source + 0.5)), 0).xyz, 1.0);
  gl_Position = projectionMatrix * seen;
}`;
export const DEPTH_FRAGMENT = `${COMMON}
out vec4 made;
void main() { made = vec4(0.0); }`;

// How near the lamp each surface point is; nothing is 0.
export const LAMP_VERTEX = `${SURFACE}
uniform mat4 lamp; out float near;
void main() {
  vec4 seen = modelViewMatrix * vec4(texelFetch(places, texel(int(source + 0.5)), 0).xyz, 1.0);
  vec4 place = lamp * seen;
  near = 1.0 - 0.5 * (place.z + 1.0);
  gl_Position = place;
}`;
export const LAMP_FRAGMENT = `${COMMON}
in float near; out vec4 made;
void main() { made = vec4(near, 0.0, 0.0, 1.0); }`;

// Where on the surface a pixel is, in the surface's own space.
export const PICK_VERTEX = `${SURFACE}
out vec3 place;
void main() {
  place = texelFetch(places, texel(int(source + 0.5)), 0).xyz;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(place, 1.0);
}`;
export const PICK_FRAGMENT = `${COMMON}
in vec3 place; out vec4 made;
void main() { made = vec4(place, 1.0); }`;

export const FACE_VERTEX = `${SURFACE}
in vec2 uv, sky, material; in vec3 colour;
uniform sampler2D normals, others; uniform float opened; uniform int heat; uniform mat3 normalMatrix;
out vec3 point, normal, tint, home; out vec2 st, kind; out float clear, amount;
uniform sampler2D still;
invariant gl_Position;
void main() {
  ivec2 here = texel(int(source + 0.5));
  vec3 place = texelFetch(places, here, 0).xyz;
  vec4 seen = modelViewMatrix * vec4(place, 1.0);
  point = seen.xyz;
  normal = normalMatrix * texelFetch(normals, here, 0).xyz;
  home = texelFetch(still, here, 0).xyz;
  tint = colour; st = uv; kind = material;
  clear = mix(sky.x, sky.y, clamp(opened, 0.0, 1.0));
  amount = heat == 0 ? 0.0 : distance(place, texelFetch(others, here, 0).xyz);
  gl_Position = projectionMatrix * seen;
}`;

export const FACE_FRAGMENT = `${COMMON}
in vec3 point, normal, tint, home; in vec2 st, kind; in float clear, amount;
uniform sampler2D skin, shadow, palette, masks;
uniform mediump sampler2DArray captures; uniform vec4 blended[${MOST_BLENDED}]; uniform int sharing; // share of each region, layer
uniform int heat, look; // look: 0 colours, 1 clay
uniform bool textured, lines;
uniform mat4 lamp; uniform float radius, limit;
uniform vec4 eyes[2]; // centre and radius, face space; radius 0: none known, eyes are as their colours are
out vec4 made;
const vec3 WRAP = vec3(0.28, 0.14, 0.09);
const vec3 LAMPS[4] = vec3[](vec3(-0.55, 0.62, 0.72), vec3(0.85, 0.10, 0.55), vec3(0.80, 0.45, -0.70), vec3(-0.85, 0.35, -0.75));
const vec3 LIGHT[4] = vec3[](vec3(1.02, 0.95, 0.86), vec3(0.20, 0.24, 0.30), vec3(0.42, 0.46, 0.52), vec3(0.26, 0.26, 0.28));
const float GLOSS[4] = float[](1.0, 1.0, 0.3, 0.3);
const vec3 SKY = vec3(0.30, 0.32, 0.35), GROUND = vec3(0.15, 0.13, 0.12);

vec3 linear(vec3 c) { return mix(c / 12.92, pow((max(c, 0.04045) + 0.055) / 1.055, vec3(2.4)), step(0.04045, c)); }
vec3 srgb(vec3 c) { c = clamp(c, 0.0, 1.0); return mix(12.92 * c, 1.055 * pow(max(c, 0.0031308), vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c)); }
float fresnel(float f0, float cosine) { float a = 1.0 - cosine, s = a * a; return f0 + (1.0 - f0) * s * s * a; }
float spline(float x) {
  float t = 0.5 * abs(x);
  if (t >= 2.0) return 0.0;
  float outer = 2.0 - t, inner = max(1.0 - t, 0.0);
  return (outer * outer * outer - 4.0 * inner * inner * inner) / 12.0;
}
// GGX with Kelemen's visibility, times pi.
float gloss(vec3 n, vec3 v, vec3 l, float f0, float roughness) {
  vec3 h = l + v;
  float cosine = dot(n, l), nh = dot(n, h);
  if (cosine <= 0.0 || nh <= 0.0) return 0.0;
  float size = dot(h, h), alpha = roughness * roughness, d = nh * nh / size * (alpha * alpha - 1.0) + 1.0;
  return cosine * alpha * alpha * fresnel(f0, 0.5 * sqrt(size)) / (d * d * max(size, 0.4) * (roughness + 0.5));
}
// Share of the key lamp that arrives: 8 x 8 texels against the tangent plane under a cubic B-spline.
float arrives(vec3 n) {
  vec3 towards = normalize(LAMPS[0]);
  float cosine = dot(n, towards);
  if (cosine <= 0.0) return 0.0;
  vec3 place = (lamp * vec4(point, 1.0)).xyz;
  float size = float(textureSize(shadow, 0).x), mm = 2.0 * radius / size; // of a texel
  vec3 across = radius * vec3(lamp[0][0], lamp[1][0], lamp[2][0]), up = radius * vec3(lamp[0][1], lamp[1][1], lamp[2][1]);
  vec2 slope = mm / max(cosine, 0.1) * vec2(dot(across, n), dot(up, n));
  vec2 uv = clamp((0.5 * place.xy + 0.5) * size - 0.5, vec2(3.0), vec2(size - 5.0));
  float depth = radius * (place.z + 1.0) - mm;
  ivec2 base = ivec2(floor(uv));
  float total = 0.0;
  for (int b = -3; b < 5; b++) for (int a = -3; a < 5; a++) {
    ivec2 here = base + ivec2(a, b);
    vec2 away = vec2(here) - uv;
    float near = texelFetch(shadow, here, 0).x;
    float gap = near == 0.0 ? -1.0 : depth + dot(slope, away) - 2.0 * radius * (1.0 - near);
    total += clamp(1.0 - gap / (2.0 * mm), 0.0, 1.0) * spline(away.x) * spline(away.y);
  }
  return total;
}
// Iris, pupil and the white by the angle from the eye's axis at rest.
vec3 iris(vec3 white) {
  for (int i = 0; i < 2; i++) {
    vec3 d = (home - eyes[i].xyz) / max(eyes[i].w, 1e-3);
    if (eyes[i].w == 0.0 || abs(length(d) - 1.0) > 0.35) continue;
    d = normalize(d);
    float away = degrees(acos(clamp(d.z, -1.0, 1.0))), turn = atan(d.y, d.x), soft = max(fwidth(away), 0.35);
    float fibre = 0.5 + 0.5 * sin(47.0 * turn + 3.0 * sin(9.0 * turn)) * sin(31.0 * turn + 1.7);
    float ring = smoothstep(9.0, 21.0, away);
    vec3 colour = mix(vec3(0.30, 0.19, 0.09), vec3(0.20, 0.14, 0.08), ring) * (0.75 + 0.5 * fibre * (1.0 - 0.5 * ring));
    colour = mix(vec3(0.012), colour, smoothstep(8.4 - soft, 8.4 + soft, away));
    colour = mix(colour, vec3(0.035, 0.028, 0.022), smoothstep(18.0, 22.0, away));
    vec3 ball = mix(white, white * vec3(1.0, 0.80, 0.76), smoothstep(40.0, 75.0, away));
    return mix(colour, ball, smoothstep(21.5, 24.5 + soft, away));
  }
  return white;
}
// T = t0 + sum_k c_k m_k (t_k - t0), the captures in use alone.
vec3 painted() {
  vec3 base = texture(skin, st).rgb, sum = base, mask = texture(masks, st).rgb;
  for (int i = 0; i < sharing; i++) sum += dot(blended[i].xyz, mask) * (texture(captures, vec3(st, blended[i].w)).rgb - base);
  return clamp(sum, 0.0, 1.0);
}
void main() {
  vec3 n = normalize(normal), v = normalize(-point);
  float open = clear;
  if (!gl_FrontFacing) { n = -n; open *= 0.35; }
  vec3 albedo = textured ? linear(painted()) : linear(tint);
  float wet = kind.x, tooth = kind.y;
  if (look == 1) { albedo = vec3(0.42); wet = 0.0; tooth = 0.0; }
  if (kind.x > 0.5 && !textured && look == 0) albedo = iris(eyes[0].w > 0.0 ? linear(vec3(0.88, 0.86, 0.84)) : albedo);
  if (tooth > 0.5 && look == 0) albedo = linear(vec3(0.90, 0.87, 0.80));
  if (heat > 0) { albedo = vec3(0.604); wet = 0.0; }
  float shine = max(wet, 0.6 * tooth);
  float f0 = mix(0.028, 0.04, shine), roughness = heat > 0 ? 1.0 : mix(0.48, 0.22, shine);
  if (heat > 0) f0 = 0.0;
  vec3 bleed = heat > 0 ? vec3(0.1) : mix(WRAP, vec3(0.12), tooth);
  float mean = (albedo.r + albedo.g + albedo.b) / 3.0, smoothness = min(4.0 * mean + shine, 1.0);
  float up = 0.5 + 0.5 * n.y, sheen = fresnel(f0, max(dot(n, v), 0.0)) * 0.35 * open * open * smoothness;
  vec3 lit = mix(GROUND, SKY, up) * (albedo * open / (1.0 - albedo * (1.0 - open) * 0.8) + sheen);
  for (int i = 0; i < 4; i++) {
    vec3 l = normalize(LAMPS[i]);
    float cosine = dot(n, l), through = 0.4 * open + 0.6 * open * open, polish = smoothness;
    if (i == 0) {
      float fade = smoothstep(0.0, 0.25, cosine);
      through = mix(open * open, arrives(n), fade); polish = 1.0;
    }
    vec3 m = shine > 0.0 ? normalize(l + wet * v) : l;
    float mirror = GLOSS[i] * polish * gloss(n, v, m, f0, roughness) * mix(through * open, 1.0, wet);
    vec3 diffuse = max(vec3(cosine) + bleed, 0.0) / ((1.0 + bleed) * (1.0 + bleed));
    vec3 arriving = through + 1.2 * bleed * through * (1.0 - through);
    lit += LIGHT[i] * (arriving * diffuse * albedo + mirror);
  }
  lit = mix(lit, 1.0 - 0.25 * exp((0.75 - lit) / 0.25), step(0.75, lit));
  if (heat > 0) {
    vec3 colour = linear(texture(palette, vec2(clamp(amount / limit, 0.0, 1.0) * 0.998 + 0.001, 0.5)).rgb);
    lit = colour * (1.0 - 0.5 * (1.0 - min((lit.r + lit.g + lit.b) / 1.8, 1.0)));
  }
  made = vec4(lines ? vec3(0.75, 0.85, 1.0) : srgb(lit), lines ? 0.35 : 1.0);
}`;

export const BACKDROP = `${COMMON}
in vec2 at; out vec4 made;
void main() {
  float away = pow(clamp(dot(at, at) / 2.0, 0.0, 1.0), 0.75);
  ivec2 p = ivec2(gl_FragCoord.xy) & 3;
  float order[16] = float[](0.,8.,2.,10.,12.,4.,14.,6.,3.,11.,1.,9.,15.,7.,13.,5.);
  made = vec4(mix(vec3(0.36, 0.37, 0.39), vec3(0.15, 0.155, 0.165), away) + (order[p.y * 4 + p.x] / 16.0 - 15.0 / 32.0) / 255.0, 1.0);
}`;
