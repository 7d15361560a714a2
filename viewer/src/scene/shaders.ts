// The programs of the scene, GLSL ES 3.0. Three's RawShaderMaterial puts `#version 300 es` and the defines before them.
//
// Frames: `place` is world_from_part less the mock-up's middle; view coordinates have the eye at the origin, -z ahead.

const PRECISION = /* glsl */ `
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;
precision highp sampler3D;
`;

// A part's state and place, by its id. The widths are those of parts.ts.
const PARTS = /* glsl */ `
uniform usampler2D states;
uniform sampler2D places;
uint stateOf(uint part) { return texelFetch(states, ivec2(int(part & 1023u), int(part >> 10)), 0).r; }
vec3 placeOf(uint part, vec3 p) {
  ivec2 at = ivec2(int(part & 255u) * 3, int(part >> 8));
  vec4 q = vec4(p, 1.0);
  return vec3(dot(texelFetch(places, at, 0), q), dot(texelFetch(places, at + ivec2(1, 0), 0), q),
    dot(texelFetch(places, at + ivec2(2, 0), 0), q));
}
`;

// A calm colour by a hash of the part's id: muted, of like lightness, far from the highlight colours.
const PALETTE = /* glsl */ `
uint hashOf(uint n) { n ^= n >> 16; n *= 0x7feb352du; n ^= n >> 15; n *= 0x846ca68bu; return n ^ (n >> 16); }
vec3 calm(uint part) {
  const vec3 calms[10] = vec3[10](
    vec3(0.62, 0.65, 0.68), vec3(0.52, 0.60, 0.66), vec3(0.66, 0.63, 0.56), vec3(0.54, 0.62, 0.56), vec3(0.70, 0.68, 0.65),
    vec3(0.57, 0.56, 0.64), vec3(0.64, 0.57, 0.54), vec3(0.47, 0.53, 0.58), vec3(0.60, 0.66, 0.63), vec3(0.72, 0.71, 0.69));
  uint h = hashOf(part + 1u);
  return calms[h % 10u] * (0.92 + 0.16 * float((h >> 8) & 255u) / 255.0);
}
`;

// The light: a sky, a key light above the left shoulder, a weak fill from the right. The normal faces the eye.
const LIGHT = /* glsl */ `
#define LIT
uniform vec3 sky;
uniform float parallel;
// The unit vector to the eye.
vec3 towards(vec3 view) { return parallel > 0.0 ? vec3(0.0, 0.0, 1.0) : -normalize(view); }
vec3 normalOf(vec3 view) {
  vec3 n = cross(dFdx(view), dFdy(view));
  float size = dot(n, n);
  return size > 0.0 ? n * inversesqrt(size) : vec3(0.0, 0.0, 1.0);
}
vec3 lit(vec3 colour, vec3 n, vec3 view) {
  vec3 key = vec3(-0.45, 0.60, 0.66);
  float shade = 0.52 + 0.16 * dot(n, sky) + 0.50 * max(dot(n, key), 0.0) + 0.22 * max(dot(n, vec3(0.75, -0.15, 0.64)), 0.0);
  vec3 halfway = normalize(key + towards(view));
  return colour * shade + 0.12 * pow(max(dot(n, halfway), 0.0), 24.0);
}
`;

// The colour that the mock-up states of a part, else a calm one. The width is that of palette.ts.
const STATED = /* glsl */ `
uniform sampler2D colours;
vec3 colourOf(uint part) {
  vec4 stated = texelFetch(colours, ivec2(int(part & 1023u), int(part >> 10)), 0);
  return stated.a > 0.5 ? stated.rgb : calm(part);
}
// A part of a finding that is looked at: its ghost is seen, too.
bool isTinted(uint part) {
  float opacity = texelFetch(colours, ivec2(int(part & 1023u), int(part >> 10)), 0).a;
  return opacity > 0.5 && opacity < 0.7;
}
`;

export const pieceVertex = `${PRECISION}${PARTS}${PALETTE}${STATED}/* glsl */
uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
in vec3 position;
in uint part;
out vec3 vView;
flat out vec3 vColour;
#ifdef GHOST
uniform vec4 ghost;
flat out vec4 vGhost;
#endif
flat out uint vPart;
#if SECTIONS > 0
out vec3 vWorld;
#endif
void main() {
  uint state = stateOf(part);
  bool isGhost = (state & 2u) != 0u;
#ifdef GHOST
  bool isOut = (state & 33u) != 0u || !isGhost;
#else
  bool isOut = (state & 33u) != 0u || isGhost;
#endif
  // Beyond every clip plane: a triangle of a part that is not drawn has no pixel.
  if (isOut) { gl_Position = vec4(2.0, 2.0, 2.0, 1.0); return; }
  vec3 p = (state & 64u) != 0u ? placeOf(part, position) : position;
  vec4 view = modelViewMatrix * vec4(p, 1.0);
  vView = view.xyz;
#if SECTIONS > 0
  vWorld = p;
#endif
  vColour = colourOf(part);
#ifdef GHOST
  vGhost = isTinted(part) ? vec4(0.3 + 0.7 * vColour, 0.14) : ghost;
#endif
  vPart = part;
  gl_Position = projectionMatrix * view;
}
`;

// Planes in world coordinates less the middle: kept where dot(plane.xyz, x) >= plane.w.
const CUT = /* glsl */ `
#if SECTIONS > 0
uniform vec4 cutPlanes[SECTIONS];
uniform vec3 cameraPosition;
uniform vec4 viewPlanes[SECTIONS];
bool isCut(vec3 p) {
  for (int i = 0; i < SECTIONS; i++) if (dot(cutPlanes[i].xyz, p) < cutPlanes[i].w) return true;
  return false;
}
// Whether the rays begin in a part cut away. Parallel ones begin beyond everything.
bool isEyeCut() {
  if (parallel <= 0.0) return isCut(cameraPosition);
  for (int i = 0; i < SECTIONS; i++) if (viewPlanes[i].z < -1e-5) return true;
  return false;
}
#endif
`;

// Colour is premultiplied. The id is the part's plus one; its highest bit marks the fill of a section.
export const pieceFragment = `${PRECISION}${LIGHT}${PALETTE}${CUT}/* glsl */
in vec3 vView;
flat in vec3 vColour;
#ifdef GHOST
flat in vec4 vGhost;
#endif
flat in uint vPart;
#if SECTIONS > 0
in vec3 vWorld;
#endif
layout(location = 0) out vec4 outColour;
layout(location = 1) out uint outId;
#if SECTIONS > 0 && !defined(GHOST)
uniform vec2 depthLine;
// A fill is drawn nearer. Of two faces in one place, as flush parts have, the back face is met first: the ray is in its part
// before it is in the other. Their depths differ where they are cut into other triangles: by rounding, a share of the
// distance, and by corners that the device puts on a grid of pixels, of 1/16 in the coarsest, which matters by the slope.
const float FILL_NEARER = 1e-5;
const float FILL_PIXELS = 0.125;
#endif
void main() {
  uint id = vPart + 1u;
  // Before pixels are left out: a slope needs its neighbours.
  vec3 n = normalOf(vView);
#if SECTIONS > 0
  float slope = fwidth(gl_FragCoord.z);
  if (isCut(vWorld)) discard;
#endif
#ifdef GHOST
  float edge = 1.0 - abs(dot(n, towards(vView)));
  float alpha = vGhost.a + 0.30 * edge * edge * edge;
  outColour = vec4(vGhost.rgb * alpha, alpha);
#else
  outColour = vec4(lit(vColour, n, vView), 1.0);
  #if SECTIONS > 0
  gl_FragDepth = gl_FragCoord.z;
  // The eye is in the part cut away: a back face is then the inside of something solid.
  if (!gl_FrontFacing && isEyeCut()) {
    uint h = hashOf(vPart + 1u);
    float across = (h & 1u) != 0u ? gl_FragCoord.x + gl_FragCoord.y : gl_FragCoord.x - gl_FragCoord.y;
    float line = smoothstep(1.4, 0.6, abs(mod(across, 9.0) - 4.5));
    // Of the part's colour: paper and ink of it.
    outColour.rgb = mix(mix(vColour, vec3(1.0), 0.18), 0.42 * vColour, 0.62 * line);
    id |= 0x80000000u;
    float toEye = parallel > 0.0 ? -1.0 : 1.0;
    float share = parallel > 0.0 ? -parallel / depthLine.x : gl_FragCoord.z + depthLine.y / depthLine.x;
    gl_FragDepth += FILL_NEARER * share + toEye * sign(depthLine.x) * FILL_PIXELS * slope;
  }
  #endif
#endif
  outId = id;
}
`;

export const screenVertex = `${PRECISION}/* glsl */
in vec3 position;
void main() { gl_Position = vec4(position.xy, 0.0, 1.0); }
`;

// A box in space, for a pass over its pixels.
export const boxVertex = `${PRECISION}/* glsl */
uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
in vec3 position;
void main() { gl_Position = projectionMatrix * (modelViewMatrix * vec4(position, 1.0)); }
`;

// Makes the kept picture from the raw one: edges between parts and at creases, over the background.
//
// A stored depth is affine in 1 / distance, and 1 / distance is affine over the pixels of a plane: its second difference
// is zero but at a crease, where it is the change of slope. In parallel projection the distance itself is.
export const resolveFragment = `${PRECISION}/* glsl */
uniform sampler2D rawColour;
uniform usampler2D rawId;
uniform sampler2D rawDepth;
uniform vec2 depthLine;
uniform vec2 drawn;
uniform float focal;
uniform float parallel;
uniform float share;
uniform vec3 above;
uniform vec3 below;
uniform vec3 line;
layout(location = 0) out vec4 outColour;
float nearness(ivec2 p) { return depthLine.x * texelFetch(rawDepth, p, 0).r + depthLine.y; }
void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  vec4 colour = texelFetch(rawColour, p, 0);
  float height = gl_FragCoord.y / drawn.y;
  // A grain of less than one step of 8 bits: a slow gradient would show bands.
  float grain = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))) - 0.5;
  vec3 back = mix(below, above, smoothstep(0.0, 1.0, height)) + grain / 255.0;
  vec3 shown = colour.rgb + (1.0 - colour.a) * back;
  uint id = texelFetch(rawId, p, 0).r;
  ivec2 last = ivec2(drawn) - 1;
  ivec2 east = ivec2(min(p.x + 1, last.x), p.y), north = ivec2(p.x, min(p.y + 1, last.y));
  uint idEast = texelFetch(rawId, east, 0).r, idNorth = texelFetch(rawId, north, 0).r;
  float edge = 0.0;
  if (id != idEast || id != idNorth) {
    edge = 0.62;
  }
#ifdef CREASES
  else if (id != 0u && (id & 0x80000000u) == 0u) {
    ivec2 west = ivec2(max(p.x - 1, 0), p.y), south = ivec2(p.x, max(p.y - 1, 0));
    float w = nearness(p);
    float bend = max(abs(nearness(east) + nearness(west) - 2.0 * w), abs(nearness(north) + nearness(south) - 2.0 * w));
    edge = 0.45 * smoothstep(0.45, 1.6, bend / (parallel > 0.0 ? 1.0 : w) * focal);
  }
#endif
  // On a dark part a dark line is not seen: there it is lighter than the part.
  float dark = id == 0u ? 0.0 : 1.0 - smoothstep(0.10, 0.26, dot(shown, vec3(0.30, 0.59, 0.11)));
  outColour = vec4(mix(shown, mix(line, shown + 0.30, dark), edge), share);
}
`;

// The kept picture at the size of the screen, with its lit parts. They are tinted here, by their ids, so that lighting one redraws
// nothing of the mock-up. A rim around selected parts is visible on any colour, and on a bolt of a few pixels; parts that
// are hit change from frame to frame and have none, as looking for it takes time.
export const tintFragment = `${PRECISION}/* glsl */
uniform sampler2D kept;
uniform vec2 keptScale;
uniform usampler2D keptId;
uniform usampler2D states;
uniform vec3 others[3];
uniform vec2 resolution;
uniform float pixelRatio;
layout(location = 0) out vec4 outColour;
const float RIM_PIXELS = 1.5;
const float OTHER_PIXELS = 3.0;
uint idAt(ivec2 p) { return texelFetch(keptId, p, 0).r & 0x7fffffffu; }
// How a part is lit: the bits hit, selected, and those of other people.
uint litOf(uint id) {
  if (id == 0u) return 0u;
  uint part = id - 1u;
  return texelFetch(states, ivec2(int(part & 1023u), int(part >> 10)), 0).r & 156u;
}
// Three places around the pixel see every edge. No edge is between two parts with the same bits.
bool isAtRim(ivec2 p, uint id, float pixels, uint mask, uint bits) {
  int rim = max(1, int(pixels * pixelRatio * keptScale.x + 0.5));
  ivec2 low = max(p - rim, ivec2(0)), high = min(p + rim, ivec2(resolution * keptScale) - 1);
  uvec3 around = uvec3(idAt(ivec2(p.x, high.y)), idAt(low), idAt(ivec2(high.x, low.y)));
  if (around == uvec3(id)) return false;
  uvec3 lit = uvec3(litOf(around.x), litOf(around.y), litOf(around.z));
  return (lit & uvec3(mask)) != uvec3(bits);
}
void main() {
  vec2 at = gl_FragCoord.xy * keptScale;
#ifdef SCALED
  vec3 colour = texture(kept, at / vec2(textureSize(kept, 0))).rgb;
#else
  vec3 colour = texelFetch(kept, ivec2(at), 0).rgb;
#endif
  ivec2 p = ivec2(at);
  uint id = idAt(p), state = litOf(id);
  if (state != 0u) {
    bool isHit = (state & 8u) != 0u, isSelected = (state & 16u) != 0u;
    float light = dot(colour, vec3(0.30, 0.59, 0.11));
    uint other = state & 132u;
    // 4, 128 and both: the first, the second and the third.
    vec3 own = others[other == 132u ? 2 : other == 128u ? 1 : 0];
    vec3 tint = isHit ? vec3(1.0, 0.56, 0.10) : isSelected ? vec3(1.0, 0.92, 0.55) : own;
    colour = mix(colour, tint * (0.40 + 0.95 * light), isHit ? 0.44 : isSelected ? 0.74 : 0.4);
    // A hatch besides the colour, so that hit and selected differ without seeing red.
    if (isHit && mod(gl_FragCoord.x + gl_FragCoord.y, 10.0) < 2.0) colour *= 0.72;
    if (other != 0u && isAtRim(p, id, OTHER_PIXELS, 132u, other)) colour = own;
    if (isSelected && isAtRim(p, id, RIM_PIXELS, 16u, 16u)) colour = vec3(1.0, 0.86, 0.24);
  }
  outColour = vec4(colour, 1.0);
}
`;

// The kept layer as a thing to hide behind: `keptDistance` is along the view direction, metres. `fragmentOffset` is where
// the target's corner lies in the picture, device pixels.
const KEPT = /* glsl */ `
uniform sampler2D keptDepth;
uniform usampler2D keptId;
uniform vec2 keptScale;
uniform vec2 depthLine;
uniform vec2 fragmentOffset;
uniform vec4 rayOf;
uniform bool hasKept;
#ifndef LIT
uniform float parallel;
#endif
#if SECTIONS > 0
uniform vec4 viewPlanes[SECTIONS];
#endif
float distanceOf(float stored) {
  float line = depthLine.x * stored + depthLine.y;
  return parallel > 0.0 ? line : 1.0 / max(line, 1e-30);
}
float keptDistance(out uint id) {
  vec2 at = gl_FragCoord.xy + fragmentOffset;
  ivec2 p = ivec2(at * keptScale);
  id = texelFetch(keptId, p, 0).r;
  float found = id == 0u ? 1e30 : distanceOf(texelFetch(keptDepth, p, 0).r);
#if SECTIONS > 0
  // A section's fill was drawn with the back face's depth; it appears where the ray enters the remaining solid.
  if ((id & 0x80000000u) != 0u) {
    vec2 ray = at * rayOf.xy + rayOf.zw;
    found = parallel > 0.0 ? -1e30 : 0.0;
    for (int i = 0; i < SECTIONS; i++) {
      vec4 plane = viewPlanes[i];
      if (parallel > 0.0) {
        if (plane.z < -1e-5) found = max(found, (plane.w - dot(plane.xy, ray)) / -plane.z);
      } else if (plane.w > 0.0) found = max(found, plane.w / dot(plane.xyz, vec3(ray, -1.0)));
    }
  }
#endif
  return found;
}
// Whether the kept layer lies before this fragment, by more than the slack (a share of the distance).
bool isBehindKept(float slack) {
  if (!hasKept) return false;
  uint id;
  float kept = keptDistance(id);
  if (parallel > 0.0) return distanceOf(gl_FragCoord.z) > kept + slack * parallel;
  return 1.0 / gl_FragCoord.w > kept * (1.0 + slack);
}
`;

export const probeFragment = `${PRECISION}${KEPT}/* glsl */
layout(location = 0) out uvec4 outFound;
void main() {
  uint id;
  float far = keptDistance(id);
  outFound = uvec4(id & 0x7fffffffu, floatBitsToUint(far), 0u, 0u);
}
`;

export const heldVertex = `${PRECISION}${PALETTE}/* glsl */
uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
in vec3 position;
in uint part;
out vec3 vView;
flat out vec3 vColour;
flat out uint vPart;
void main() {
  vec4 view = modelViewMatrix * vec4(position, 1.0);
  vView = view.xyz;
  vColour = part == 0u ? vec3(0.40, 0.78, 0.72) : mix(vec3(0.40, 0.78, 0.72), calm(part), 0.45);
  vPart = part;
  gl_Position = projectionMatrix * view;
}
`;

export const heldFragment = `${PRECISION}${LIGHT}${KEPT}/* glsl */
in vec3 vView;
flat in vec3 vColour;
flat in uint vPart;
#ifdef PROBE
layout(location = 0) out uvec4 outFound;
#else
layout(location = 0) out vec4 outColour;
#endif
void main() {
  // Before pixels are left out: a slope needs its neighbours.
  vec3 n = normalOf(vView);
  bool isBehind = isBehindKept(0.0);
#ifdef PROBE
  if (isBehind) discard;
  outFound = uvec4(vPart + 1u, floatBitsToUint(-vView.z), 1u, 0u);
#elif defined(GHOST)
  float edge = 1.0 - abs(dot(n, towards(vView)));
  float alpha = 0.10 + 0.45 * edge * edge;
  outColour = vec4(vec3(0.55, 0.88, 0.83), isBehind ? 0.45 * alpha : alpha);
#else
  if (isBehind) discard;
  outColour = vec4(lit(vColour, n, vView), 1.0);
#endif
}
`;

// The held mesh, drawn aside, put over the kept picture: with an outline and creases; what the mock-up hides, faintly.
export const heldOverFragment = `${PRECISION}${KEPT}/* glsl */
uniform sampler2D heldColour;
uniform sampler2D heldDepth;
uniform float pixelRatio;
layout(location = 0) out vec4 outColour;
float coverAt(ivec2 p) { return texelFetch(heldColour, p, 0).a; }
float lineAt(ivec2 p) { return depthLine.x * texelFetch(heldDepth, p, 0).r + depthLine.y; }
void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  ivec2 last = textureSize(heldColour, 0) - 1;
  int rim = max(1, int(pixelRatio + 0.5));
  ivec2 around[4] = ivec2[4](ivec2(min(p.x + rim, last.x), p.y), ivec2(max(p.x - rim, 0), p.y),
    ivec2(p.x, min(p.y + rim, last.y)), ivec2(p.x, max(p.y - rim, 0)));
  ivec2 at = p;
  bool isRim = coverAt(p) == 0.0;
  if (isRim) {
    int found = -1;
    for (int k = 0; k < 4; k++) if (found < 0 && coverAt(around[k]) > 0.0) found = k;
    if (found < 0) discard;
    at = around[found];
  }
  float stored = texelFetch(heldDepth, at, 0).r;
  float mine = distanceOf(stored);
  uint id;
  float kept = hasKept ? keptDistance(id) : 1e30;
  bool isBehind = mine > kept;
  float crease = isRim ? 1.0 : 0.0;
  if (!isRim) {
    float w = lineAt(p);
    vec2 bend = abs(vec2(lineAt(p + ivec2(1, 0)) + lineAt(p - ivec2(1, 0)), lineAt(p + ivec2(0, 1)) + lineAt(p - ivec2(0, 1))) - 2.0 * w);
    crease = 0.45 * smoothstep(0.45, 1.6, max(bend.x, bend.y) / (parallel > 0.0 ? 1.0 : w) / rayOf.x);
  }
  vec3 colour = texelFetch(heldColour, at, 0).rgb;
  if (isBehind) outColour = vec4(mix(colour, vec3(0.62, 1.0, 0.94), isRim ? 1.0 : 0.35), isRim ? 0.80 : 0.20 + 0.5 * crease);
  else outColour = vec4(mix(colour, vec3(0.01, 0.09, 0.09), crease), 1.0);
  gl_FragDepth = stored;
}
`;

// Surfaces of the kept picture near the held mesh, by their distance to it: orange at contact, blue at the reach, a line
// each quarter of it.
export const heatFragment = `${PRECISION}${KEPT}/* glsl */
uniform sampler3D field;
uniform mat4 fieldFromView;
uniform vec3 fieldEdge;
uniform float fieldScale;
uniform float heatReach;
layout(location = 0) out vec4 outColour;
void main() {
  uint id;
  float far = keptDistance(id);
  vec2 ray = (gl_FragCoord.xy + fragmentOffset) * rayOf.xy + rayOf.zw;
  vec3 view = vec3(parallel > 0.0 ? ray : ray * far, -far);
  vec3 at = (fieldFromView * vec4(view, 1.0)).xyz;
  float share = texture(field, clamp(at, fieldEdge, 1.0 - fieldEdge)).r * fieldScale / heatReach;
  float quarter = 4.0 * share;
  float slope = fwidth(quarter);
  if (id == 0u || any(lessThan(at, fieldEdge)) || any(greaterThan(at, 1.0 - fieldEdge)) || share >= 1.0) discard;
  vec3 colour = share < 0.5 ? mix(vec3(1.0, 0.46, 0.06), vec3(1.0, 0.86, 0.36), 2.0 * share)
    : mix(vec3(1.0, 0.86, 0.36), vec3(0.24, 0.58, 1.0), 2.0 * share - 1.0);
  float line = slope < 0.4 ? 1.0 - smoothstep(0.6, 1.4, abs(fract(quarter + 0.5) - 0.5) / max(slope, 1e-5)) : 0.0;
  if (quarter < 0.5) line = 0.0;
  outColour = vec4(mix(colour, 0.35 * colour, 0.6 * line), mix(0.74, 0.30, share) + 0.2 * line);
}
`;

// Colliding triangles, of the mock-up or of the held mesh: solid where visible, faint where covered.
export const hitVertex = `${PRECISION}/* glsl */
uniform float parallel;
uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
in vec3 position;
void main() {
  vec4 view = modelViewMatrix * vec4(position, 1.0);
  // A little towards the eye along the ray: the same pixel, before the surface that the triangle is part of.
  vec3 nearer = parallel > 0.0 ? view.xyz + vec3(0.0, 0.0, 1e-4 * parallel) : view.xyz * 0.9999;
  gl_Position = projectionMatrix * vec4(nearer, 1.0);
}
`;

export const hitFragment = `${PRECISION}${KEPT}/* glsl */
uniform vec4 colour;
layout(location = 0) out vec4 outColour;
void main() {
#ifdef BEHIND
  outColour = vec4(colour.rgb, colour.a * 0.30);
#else
  if (isBehindKept(2e-4)) discard;
  outColour = colour;
#endif
}
`;

// Lines of a width in device pixels: an instance is a segment, round at its ends; unlike widths make the head of an arrow.
export const lineVertex = `${PRECISION}/* glsl */
uniform mat4 viewMatrix;
uniform mat4 projectionMatrix;
uniform vec2 resolution;
uniform float pixelRatio;
uniform float nearest;
in vec3 position;
in vec3 from;
in vec3 to;
in vec4 tint;
in vec2 widths;
out vec2 vAt;
flat out vec3 vReach;
flat out vec4 vTint;
void main() {
  vec4 a = viewMatrix * vec4(from, 1.0), b = viewMatrix * vec4(to, 1.0);
  // Before the eye: cut at the near plane, else the projected end would come from behind.
  float cut = -nearest;
  if (a.z > cut && b.z > cut) { gl_Position = vec4(2.0, 2.0, 2.0, 1.0); return; }
  if (a.z > cut) a = mix(a, b, (a.z - cut) / (a.z - b.z));
  if (b.z > cut) b = mix(b, a, (b.z - cut) / (b.z - a.z));
  vec4 clipA = projectionMatrix * a, clipB = projectionMatrix * b;
  vec2 pixelA = clipA.xy / clipA.w * resolution * 0.5, pixelB = clipB.xy / clipB.w * resolution * 0.5;
  vec2 along = pixelB - pixelA;
  float size = length(along);
  along = size > 1e-3 ? along / size : vec2(1.0, 0.0);
  vec2 radii = widths * pixelRatio * 0.5;
  float radius = max(radii.x, radii.y) + 1.0;
  bool isEnd = position.x > 0.0;
  vec2 pixel = (isEnd ? pixelB + along * radius : pixelA - along * radius) + vec2(-along.y, along.x) * position.y * radius;
  vAt = vec2(isEnd ? size + radius : -radius, position.y * radius);
  vReach = vec3(size, radii);
  vTint = tint;
  vec4 clip = isEnd ? clipB : clipA;
  // vAt is affine over the pixels, not over space: it is multiplied by w here and divided by it in the fragment.
  vAt *= clip.w;
  gl_Position = vec4(pixel / (resolution * 0.5) * clip.w, clip.zw);
}
`;

export const lineFragment = `${PRECISION}${KEPT}/* glsl */
uniform float behind;
in vec2 vAt;
flat in vec3 vReach;
flat in vec4 vTint;
layout(location = 0) out vec4 outColour;
void main() {
  vec2 at = vAt * gl_FragCoord.w;
  float along = clamp(at.x, 0.0, vReach.x);
  float radius = mix(vReach.y, vReach.z, vReach.x > 0.0 ? along / vReach.x : 0.0);
  float alpha = clamp(radius - length(at - vec2(along, 0.0)) + 0.5, 0.0, 1.0);
  if (isBehindKept(1e-3)) alpha *= behind;
  if (alpha <= 0.004) discard;
  outColour = vec4(vTint.rgb, vTint.a * alpha);
}
`;

// Discs in space: contact planes and the ring of the snap marker.
export const discVertex = `${PRECISION}/* glsl */
uniform mat4 viewMatrix;
uniform mat4 projectionMatrix;
in vec3 position;
in vec3 middle;
in vec3 across;
in vec3 up;
in vec4 tint;
in float hole;
out vec2 vAt;
flat out vec4 vTint;
flat out float vHole;
void main() {
  vAt = position.xy;
  vTint = tint;
  vHole = hole;
  gl_Position = projectionMatrix * (viewMatrix * vec4(middle + across * position.x + up * position.y, 1.0));
}
`;

export const discFragment = `${PRECISION}${KEPT}/* glsl */
uniform float behind;
in vec2 vAt;
flat in vec4 vTint;
flat in float vHole;
layout(location = 0) out vec4 outColour;
void main() {
  float r = length(vAt);
  float step = max(fwidth(r), 1e-4);
  float rim = clamp((1.0 - r) / step, 0.0, 1.0) * clamp((r - 0.86) / step + 0.5, 0.0, 1.0);
  float inside = clamp((1.0 - r) / step, 0.0, 1.0) * clamp((r - vHole) / step + 0.5, 0.0, 1.0);
  float alpha = max(rim, 0.42 * inside);
  if (isBehindKept(1e-3)) alpha *= behind;
  if (alpha <= 0.004) discard;
  outColour = vec4(vTint.rgb, vTint.a * alpha);
}
`;

// The background alone: where nothing is kept (in a headset).
export const backFragment = `${PRECISION}/* glsl */
uniform vec2 drawn;
uniform vec3 above;
uniform vec3 below;
layout(location = 0) out vec4 outColour;
void main() { outColour = vec4(mix(below, above, smoothstep(0.0, 1.0, gl_FragCoord.y / drawn.y)), 1.0); }
`;

// A share of a picture: averages pictures that were drawn a part of a pixel apart.
export const averageFragment = `${PRECISION}/* glsl */
uniform sampler2D picture;
uniform float share;
layout(location = 0) out vec4 outColour;
void main() { outColour = vec4(texelFetch(picture, ivec2(gl_FragCoord.xy), 0).rgb, share); }
`;
