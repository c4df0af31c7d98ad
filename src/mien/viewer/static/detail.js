// Both displacement maps evaluated on the GPU, frame by frame (Ma et al. 2008, eq. 1 and 3). Plain WebGL 2.
"use strict";
const told = document.getElementById("told");
const input = (name) => document.getElementById(name);

const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
const D = window.DETAIL;
const floats = (name) => new Float32Array(bytes(D[name]));
const WIDTH = D.width; // of the textures that hold one vertex a texel

const COMMON = `#version 300 es
precision highp float; precision highp int; precision highp sampler2DArray; precision highp sampler2D;
// eq. 1 with coefficients (d1^2, d2^2, d1 d2, d1, d2, 1)
float polynomial(vec2 d, vec4 a, vec2 b) { return (a.x*d.x + a.z*d.y + a.w)*d.x + (a.y*d.y + b.x)*d.y + b.y; }
`;
const VERTEX = COMMON + `
layout(location = 0) in vec3 place;   // triangle of the coarse mesh, two barycentric weights
layout(location = 1) in vec2 at;      // texture coordinates
uniform sampler2DArray modes;         // layers: rest and modes of the position, then of dP/du, then of dP/dv
uniform sampler2DArray coefficients;  // of the medium map, six layers of (u, v, n)
uniform sampler2D forms;              // 3 texels a triangle: d1 and d2 as quadratic forms in the weights
uniform float amount[${D.modes}];
uniform mat4 camera;
uniform float medium;
uniform bool readback;
uniform ivec2 side;
out vec3 position, normal; out vec2 uv, d;
vec3 sum(int first) {
  ivec2 texel = ivec2(gl_VertexID % ${WIDTH}, gl_VertexID / ${WIDTH});
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
  ivec2 texel = ivec2(gl_VertexID % ${WIDTH}, gl_VertexID / ${WIDTH});
  float power[6] = float[](d.x*d.x, d.y*d.y, d.x*d.y, d.x, d.y, 1.0);
  vec3 offset = vec3(0);
  for (int m = 0; m < 6; m++) offset += power[m] * texelFetch(coefficients, ivec3(texel, m), 0).xyz;
  position = shell + medium * (offset.x * u + offset.y * cross(n, u) + offset.z * n);
  normal = n; uv = at;
  gl_Position = camera * vec4(position, 1);
  if (readback) {
    gl_Position = vec4(2.0 * (vec2(texel) + 0.5) / vec2(side) - 1.0, 0, 1);
    gl_PointSize = 1.0;
  }
}`;
const FRAGMENT = COMMON + `
in vec3 position, normal; in vec2 uv, d;
uniform sampler2D fine4, fine2, medium4, medium2;
uniform float fine, medium, light;
uniform bool fields, readback;
uniform mat3 turn;
layout(location = 0) out vec4 color;
void main() {
  vec2 st = vec2(uv.x, 1.0 - uv.y);
  float height = polynomial(d, texture(fine4, st), texture(fine2, st).xy);
  if (readback) { color = vec4(position, height); return; }
  float relief = fine * height + medium * polynomial(d, texture(medium4, st), texture(medium2, st).xy);
  vec3 px = dFdx(position), py = dFdy(position), n = normalize(normal);
  vec3 across = cross(py, n), up = cross(n, px);
  float area = dot(px, across);
  n = normalize(abs(area) * n - sign(area) * (dFdx(relief) * across + dFdy(relief) * up)); // Mikkelsen 2010
  n = turn * n;
  vec3 lamp = normalize(vec3(sin(light), 0.5, cos(light))), half_way = normalize(lamp + vec3(0, 0, 1));
  vec3 skin = fields ? vec3(0.5) + vec3(d, -d.x) * 0.25 : vec3(0.62, 0.42, 0.34);
  float shade = max(dot(n, lamp), 0.0), gloss = pow(max(dot(n, half_way), 0.0), 24.0);
  vec3 lit = skin * (0.22 + 0.25 * max(dot(n, vec3(-0.8, 0.1, 0.5)), 0.0) + 0.85 * shade) + 0.12 * gloss;
  color = vec4(pow(lit, vec3(1.0 / 2.2)), 1);
}`;

const canvas = input("picture");
const gl = canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });
if (!gl || !gl.getExtension("EXT_color_buffer_float")) throw told.textContent = "this page needs WebGL 2 with float targets";
gl.getExtension("OES_texture_float_linear");

function shader(kind, source) {
  const made = gl.createShader(kind);
  gl.shaderSource(made, source); gl.compileShader(made);
  if (!gl.getShaderParameter(made, gl.COMPILE_STATUS)) throw told.textContent = gl.getShaderInfoLog(made);
  return made;
}
const program = gl.createProgram();
gl.attachShader(program, shader(gl.VERTEX_SHADER, VERTEX));
gl.attachShader(program, shader(gl.FRAGMENT_SHADER, FRAGMENT));
gl.linkProgram(program);
if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw told.textContent = gl.getProgramInfoLog(program);
gl.useProgram(program);
const where = (name) => gl.getUniformLocation(program, name);

let unit = 0;
function texture(name, target, filter, fill) {
  gl.activeTexture(gl.TEXTURE0 + unit);
  gl.bindTexture(target, gl.createTexture());
  fill();
  gl.texParameteri(target, gl.TEXTURE_MIN_FILTER, filter); gl.texParameteri(target, gl.TEXTURE_MAG_FILTER, filter);
  gl.texParameteri(target, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE); gl.texParameteri(target, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
  gl.uniform1i(where(name), unit);
  return unit++;
}
const A = gl.TEXTURE_2D_ARRAY, T = gl.TEXTURE_2D, F = gl.FLOAT, H = gl.HALF_FLOAT;
const layers = (name, data, count) => texture(name, A, gl.NEAREST, () =>
  gl.texImage3D(A, 0, gl.RGB32F, WIDTH, D.rows, count, 0, gl.RGB, F, floats(data)));
layers("modes", "modes_texture", 3 * (D.modes + 1));
layers("coefficients", "coefficients", 6);
for (const name of ["fine", "medium"]) {
  const half = new Uint16Array(bytes(D[name])), size = D[name + "_size"], split = 4 * size * size;
  texture(name + "4", T, gl.LINEAR, () =>
    gl.texImage2D(T, 0, gl.RGBA16F, size, size, 0, gl.RGBA, H, half.subarray(0, split)));
  texture(name + "2", T, gl.LINEAR, () =>
    gl.texImage2D(T, 0, gl.RG16F, size, size, 0, gl.RG, H, half.subarray(split)));
}
const forms = floats("forms"), amounts = floats("amounts"), perFrame = 12 * D.triangles;
const formsUnit = texture("forms", T, gl.NEAREST, () =>
  gl.texImage2D(T, 0, gl.RGBA32F, 3, D.triangles, 0, gl.RGBA, F, forms.subarray(0, perFrame)));

function attribute(index, size, values) {
  gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
  gl.enableVertexAttribArray(index); gl.vertexAttribPointer(index, size, F, false, 0, 0);
}
attribute(0, 3, floats("place"));
attribute(1, 2, floats("uv"));
const faces = new Uint32Array(bytes(D.faces));
gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, faces, gl.STATIC_DRAW);
gl.enable(gl.DEPTH_TEST);

let yaw = 0, pitch = 0, away = 3.2;
function show(frame) {
  gl.uniform1fv(where("amount"), amounts.subarray(frame * D.modes, (frame + 1) * D.modes));
  gl.activeTexture(gl.TEXTURE0 + formsUnit);
  gl.texSubImage2D(T, 0, 0, 0, 3, D.triangles, gl.RGBA, F, forms.subarray(frame * perFrame, (frame + 1) * perFrame));
  for (const name of ["medium", "fine", "light"]) gl.uniform1f(where(name), +input(name).value);
  gl.uniform1i(where("fields"), input("fields").checked);
}
function draw(frame) {
  const ratio = window.devicePixelRatio || 1;
  canvas.width = canvas.clientWidth * ratio; canvas.height = canvas.clientHeight * ratio;
  gl.viewport(0, 0, canvas.width, canvas.height);
  gl.clearColor(0.09, 0.094, 0.1, 1); gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  show(frame);
  const [cy, sy, cx, sx] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
  const R = [cy, sx * sy, -cx * sy, 0, cx, sx, sy, -sx * cy, cx * cy];  // columns: about y, then x
  const [mx, my, mz] = D.middle, distance = away * D.radius, near = distance / 20, far = distance * 4;
  const shift = [0, 1, 2].map((i) => -(R[i] * mx + R[3 + i] * my + R[6 + i] * mz));
  shift[2] -= distance;
  const fx = 2.6 * Math.min(1, canvas.height / canvas.width), fy = fx * canvas.width / canvas.height;
  const row = (i) => [R[i], R[3 + i], R[6 + i], shift[i]];
  const [x, y, z] = [row(0), row(1), row(2)], p = (near + far) / (near - far), q = 2 * near * far / (near - far);
  const camera = [];
  for (let c = 0; c < 4; c++) camera.push(fx * x[c], fy * y[c], p * z[c] + (c === 3 ? q : 0), -z[c]);
  gl.uniformMatrix4fv(where("camera"), false, camera);
  gl.uniformMatrix3fv(where("turn"), false, R);
  gl.uniform1i(where("readback"), 0);
  gl.drawElements(gl.TRIANGLES, faces.length, gl.UNSIGNED_INT, 0);
}
// Every vertex's place and fine height as the shader finds them, one texel each: what tests compare with the library.
function check(frame) {
  gl.bindFramebuffer(gl.FRAMEBUFFER, gl.createFramebuffer());
  gl.activeTexture(gl.TEXTURE0 + unit);
  const target = gl.createTexture();
  gl.bindTexture(T, target);
  gl.texStorage2D(T, 1, gl.RGBA32F, WIDTH, D.rows);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, T, target, 0);
  gl.viewport(0, 0, WIDTH, D.rows);
  show(frame);
  gl.uniform1i(where("readback"), 1); gl.uniform2i(where("side"), WIDTH, D.rows);
  gl.drawArrays(gl.POINTS, 0, D.vertices);
  const out = new Float32Array(4 * WIDTH * D.rows);
  gl.readPixels(0, 0, WIDTH, D.rows, gl.RGBA, F, out);
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  let text = ""; for (const byte of new Uint8Array(out.buffer)) text += String.fromCharCode(byte);
  return btoa(text);
}

canvas.addEventListener("pointermove", (e) => { if (e.buttons) { yaw += e.movementX / 150; pitch += e.movementY / 150; } });
canvas.addEventListener("wheel", (e) => { away *= Math.exp(e.deltaY / 1000); e.preventDefault(); }, { passive: false });
input("frame").max = D.frames - 1;
input("controls").addEventListener("submit", (e) => e.preventDefault());
input("frame").addEventListener("input", () => { input("play").checked = false; });
const asked = location.hash.match(/check=(\d+)/), still = location.hash.match(/frame=(\d+)/);
if (asked) {
  const found = document.createElement("pre");
  found.id = "readback"; found.textContent = check(+asked[1]);
  document.body.replaceChildren(found);
} else if (still) {
  input("frame").value = still[1]; input("play").checked = false; draw(+still[1]);
} else {
  const tick = (now) => {
    if (input("play").checked) input("frame").value = Math.floor(now / 1000 * D.rate) % D.frames;
    draw(+input("frame").value);
    told.textContent = `frame ${input("frame").value} of ${D.frames}`;
    requestAnimationFrame(tick);
  };
  requestAnimationFrame(tick);
}
