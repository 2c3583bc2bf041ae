"use strict";
// Draws a robot of simple solids on a canvas, hidden surfaces removed by a depth buffer: needs no graphics card. A pose
// is 12 numbers, rotation by columns, then translation; lengths in m, the world's z is up.

const IDENTITY = [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0];
const ROUND_SIDES = 28;   // of a cylinder
const BALL_RINGS = 12;    // of a sphere, from pole to pole
const NEAREST = 0.02;     // of the camera's distance: what is nearer is not drawn

function timesPose(a, b) {
  const out = new Array(12);
  for (let column = 0; column < 4; ++column)
    for (let row = 0; row < 3; ++row)
      out[3 * column + row] = a[row] * b[3 * column] + a[3 + row] * b[3 * column + 1] + a[6 + row] * b[3 * column + 2] +
                              (column === 3 ? a[9 + row] : 0);
  return out;
}

// Rotation about a unit axis (Rodrigues), or a shift along it.
function jointPose(axis, value, slides) {
  const [x, y, z] = axis;
  if (slides) return [1, 0, 0, 0, 1, 0, 0, 0, 1, x * value, y * value, z * value];
  const c = Math.cos(value), s = Math.sin(value), d = 1 - c;
  return [c + x * x * d, y * x * d + z * s, z * x * d - y * s,
          x * y * d - z * s, c + y * y * d, z * y * d + x * s,
          x * z * d + y * s, y * z * d - x * s, c + z * z * d, 0, 0, 0];
}

// World poses of all bodies for joint positions `q`; joint i moves body i.
function bodyPoses(joints, q) {
  const poses = [];
  joints.forEach((joint, i) => {
    const parent = joint.parent < 0 ? IDENTITY : poses[joint.parent];
    poses.push(timesPose(timesPose(parent, joint.origin), jointPose(joint.axis, q[i], joint.slides)));
  });
  return poses;
}

// Triangles as [corner, normal] lists of nine numbers each, in the solid's own frame.
function boxMesh([a, b, c]) {
  const mesh = [];
  for (let axis = 0; axis < 3; ++axis) {
    for (const side of [-1, 1]) {
      const u = (axis + 1) % 3, v = (axis + 2) % 3;
      const half = [a, b, c], normal = [0, 0, 0];
      normal[axis] = side;
      const corner = (su, sv) => {
        const p = [0, 0, 0];
        p[axis] = side * half[axis];
        p[u] = su * half[u];
        p[v] = sv * half[v];
        return p;
      };
      const [p, q, r, s] = [corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)];
      const order = side > 0 ? [[p, q, r], [p, r, s]] : [[p, r, q], [p, s, r]];
      for (const corners of order) mesh.push([corners.flat(), [...normal, ...normal, ...normal]]);
    }
  }
  return mesh;
}

// A surface of revolution about z: profile points [radius, z, normal's radius, normal's z] from the bottom up.
function turnedMesh(profile) {
  const mesh = [];
  const at = ([radius, z, nr, nz], k) => {
    const angle = (2 * Math.PI * k) / ROUND_SIDES, c = Math.cos(angle), s = Math.sin(angle);
    return [[radius * c, radius * s, z], [nr * c, nr * s, nz]];
  };
  for (let i = 0; i + 1 < profile.length; ++i) {
    for (let k = 0; k < ROUND_SIDES; ++k) {
      const a = at(profile[i], k), b = at(profile[i], k + 1), c = at(profile[i + 1], k + 1), d = at(profile[i + 1], k);
      for (const corners of [[a, b, c], [a, c, d]])
        mesh.push([corners.flatMap((x) => x[0]), corners.flatMap((x) => x[1])]);
    }
  }
  return mesh;
}

function arc(radius, z, from, to) {
  const profile = [];
  for (let k = 0; k <= BALL_RINGS; ++k) {
    const angle = from + ((to - from) * k) / BALL_RINGS;
    profile.push([radius * Math.cos(angle), z + radius * Math.sin(angle), Math.cos(angle), Math.sin(angle)]);
  }
  return profile;
}

// Vertices are whole steps of the box about the middle; a face is lit evenly.
function facetsOf({ half, steps, vertices, triangles }) {
  const mesh = [], at = (i) => half.map((h, k) => h * ((2 * vertices[3 * i + k]) / steps - 1));
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [at(triangles[t]), at(triangles[t + 1]), at(triangles[t + 2])];
    const [ux, uy, uz] = b.map((v, k) => v - a[k]), [vx, vy, vz] = c.map((v, k) => v - a[k]);
    const normal = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx], size = Math.hypot(...normal);
    if (size === 0) continue;
    const unit = normal.map((v) => v / size);
    mesh.push([[...a, ...b, ...c], [...unit, ...unit, ...unit]]);
  }
  return mesh;
}

function meshOf(solid) {
  const [radius, , half] = solid.half;
  if (solid.kind === "mesh") return facetsOf(solid);
  if (solid.kind === "box") return boxMesh(solid.half);
  if (solid.kind === "sphere") return turnedMesh(arc(radius, 0, -Math.PI / 2, Math.PI / 2));
  if (solid.kind === "capsule")
    return turnedMesh([...arc(radius, -half, -Math.PI / 2, 0), ...arc(radius, half, 0, Math.PI / 2)]);
  return turnedMesh([[0, -half, 0, -1], [radius, -half, 0, -1], [radius, -half, 1, 0], [radius, half, 1, 0],
                     [radius, half, 0, 1], [0, half, 0, 1]]);
}

class View {
  constructor(camera) {
    this.home = camera;
    this.reset();
  }
  reset() {
    this.azimuth = this.home.azimuth;
    this.elevation = this.home.elevation;
    this.distance = this.home.distance;
  }
  resize(width, height) {
    this.width = width;
    this.height = height;
    const tangent = Math.tan(this.home.view / 2) * Math.max(1, (this.home.aspect * height) / width);
    this.scale = height / 2 / tangent;  // px a unit of tangent
    const ca = Math.cos(this.azimuth), sa = Math.sin(this.azimuth);
    const ce = Math.cos(this.elevation), se = Math.sin(this.elevation);
    this.sight = [ce * ca, ce * sa, se];
    this.right = [sa, -ca, 0];
    this.up = [-se * ca, -se * sa, ce];
    this.eye = this.home.target.map((t, i) => t - this.distance * this.sight[i]);
  }
  // [x, y, depth]: px from the top left, m along the direction of sight.
  project(x, y, z) {
    const a = x - this.eye[0], b = y - this.eye[1], c = z - this.eye[2];
    const depth = a * this.sight[0] + b * this.sight[1] + c * this.sight[2];
    const k = this.scale / depth;
    return [this.width / 2 + k * (a * this.right[0] + b * this.right[1]),
            this.height / 2 - k * (a * this.up[0] + b * this.up[1] + c * this.up[2]), depth];
  }
}

// One picture of solids: colours, depth, and which solid each pixel shows.
class Raster {
  resize(width, height) {
    if (this.image && this.image.width === width && this.image.height === height) return;
    this.image = new ImageData(width, height);
    this.pixels = new Uint32Array(this.image.data.buffer);
    this.closeness = new Float32Array(width * height);
    this.owner = new Uint16Array(width * height);
    this.canvas = document.createElement("canvas");
    this.canvas.width = width;
    this.canvas.height = height;
  }
  clear() {
    this.pixels.fill(0);
    this.closeness.fill(0);
    this.owner.fill(0);
  }

  // Screen corners a, b, c: [x, y, depth]; shades: how light each is.
  triangle(a, b, c, shades, color, owner) {
    const area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    if (!(area < 0)) return;  // seen from behind
    const { width, height } = this.image;
    const left = Math.max(0, Math.ceil(Math.min(a[0], b[0], c[0]) - 0.5));
    const right = Math.min(width - 1, Math.floor(Math.max(a[0], b[0], c[0]) - 0.5));
    const top = Math.max(0, Math.ceil(Math.min(a[1], b[1], c[1]) - 0.5));
    const bottom = Math.min(height - 1, Math.floor(Math.max(a[1], b[1], c[1]) - 0.5));
    if (left > right || top > bottom) return;
    const inverse = 1 / area, near = [1 / a[2], 1 / b[2], 1 / c[2]];
    // Shares of b and c change evenly along a row.
    const stepB = (c[1] - a[1]) * inverse, stepC = -(b[1] - a[1]) * inverse;
    for (let y = top; y <= bottom; ++y) {
      const px = left + 0.5 - a[0], py = y + 0.5 - a[1];
      let wb = (px * (c[1] - a[1]) - py * (c[0] - a[0])) * inverse;
      let wc = (py * (b[0] - a[0]) - px * (b[1] - a[1])) * inverse;
      let at = y * width + left;
      for (let x = left; x <= right; ++x, ++at, wb += stepB, wc += stepC) {
        const wa = 1 - wb - wc;
        if (wa < 0 || wb < 0 || wc < 0) continue;
        const closeness = wa * near[0] + wb * near[1] + wc * near[2];
        if (closeness <= this.closeness[at]) continue;
        this.closeness[at] = closeness;
        this.owner[at] = owner;
        const shade = wa * shades[0] + wb * shades[1] + wc * shades[2];
        const r = Math.min(255, color[0] * shade), g = Math.min(255, color[1] * shade), b8 = Math.min(255, color[2] * shade);
        this.pixels[at] = 0xff000000 | (b8 << 16) | (g << 8) | r;
      }
    }
  }

  // A dark line where one solid ends before another.
  outline(color, strength) {
    const { width, height } = this.image, { owner, pixels } = this;
    const rest = 1 - strength;
    for (let y = 0; y + 1 < height; ++y) {
      for (let x = 0, at = y * width; x + 1 < width; ++x, ++at) {
        const own = owner[at];
        if (own === owner[at + 1] && own === owner[at + width]) continue;
        for (const place of [at, own === owner[at + 1] ? at + width : at + 1]) {
          const p = pixels[place];
          if (p === 0) continue;
          const mix = (shift, c) => (((p >> shift) & 255) * rest + c * strength) << shift;
          pixels[place] = 0xff000000 | mix(16, color[2]) | mix(8, color[1]) | mix(0, color[0]);
        }
      }
    }
  }

  put(context, alpha) {
    this.canvas.getContext("2d").putImageData(this.image, 0, 0);
    context.globalAlpha = alpha;
    context.drawImage(this.canvas, 0, 0);
    context.globalAlpha = 1;
  }
}

// A pose at `middle` whose z axis has the direction of `way`.
function poseAlong(middle, way) {
  const size = Math.hypot(...way), z = size > 0 ? way.map((v) => v / size) : [0, 0, 1];
  const least = z.map(Math.abs).indexOf(Math.min(...z.map(Math.abs)));
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const side = cross([0, 1, 2].map((k) => (k === least ? 1 : 0)), z), length = Math.hypot(...side);
  const x = side.map((v) => v / length);
  return [...x, ...cross(z, x), ...z, ...middle];
}

// The robot's solids, ready to be drawn in any pose.
class Figure {
  constructor(solids) {
    this.solids = solids.map((solid) => ({ ...solid, mesh: meshOf(solid) }));
  }

  // World pose and triangles of a solid. Barrel and rod of a cylinder lie between their pins.
  placed(solid, poses) {
    const carried = ({ body, pose }) => timesPose(body < 0 ? IDENTITY : poses[body], pose);
    if (!solid.between) return { pose: carried(solid), mesh: solid.mesh };
    const [from, to] = solid.between.map((index) => carried(this.solids[index]).slice(9));
    const way = to.map((v, k) => v - from[k]), length = Math.hypot(...way), barrel = Math.min(solid.barrel, length);
    const [start, end] = solid.part === "barrel" ? [0, barrel] : [barrel, length];
    const share = length > 0 ? (start + end) / 2 / length : 0;
    return { pose: poseAlong(from.map((v, k) => v + share * way[k]), way),
             mesh: meshOf({ kind: solid.kind, half: [solid.half[0], 0, (end - start) / 2] }) };
  }

  // Into `raster`; `colorOf(solid)` gives three numbers 0..255.
  draw(raster, view, poses, colorOf) {
    this.solids.forEach((solid, index) => {
      const { pose, mesh } = this.placed(solid, poses);
      const color = colorOf(solid);
      const open = solid.kind === "mesh";  // may be seen from inside, or have faces that are turned round
      for (const [points, normals] of mesh) this.place(raster, view, pose, points, normals, color, index + 1, open);
    });
  }

  place(raster, view, pose, points, normals, color, owner, open) {
    const corners = [];
    for (let k = 0; k < 9; k += 3) {
      const [x, y, z] = [points[k], points[k + 1], points[k + 2]];
      const corner = view.project(pose[0] * x + pose[3] * y + pose[6] * z + pose[9],
                                  pose[1] * x + pose[4] * y + pose[7] * z + pose[10],
                                  pose[2] * x + pose[5] * y + pose[8] * z + pose[11]);
      if (corner[2] < NEAREST * view.distance) return;
      corners.push(corner);
    }
    const [a, b, c] = corners, behind = open && (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0;
    const shades = [], side = behind ? -1 : 1;
    for (let k = 0; k < 9; k += 3)
      shades.push(this.shade(view, pose, side * normals[k], side * normals[k + 1], side * normals[k + 2]));
    if (behind) raster.triangle(a, c, b, [shades[0], shades[2], shades[1]], color, owner);
    else raster.triangle(corners[0], corners[1], corners[2], shades, color, owner);
  }

  // Light from above, some from over the beholder's left shoulder.
  shade(view, pose, x, y, z) {
    const nx = pose[0] * x + pose[3] * y + pose[6] * z, ny = pose[1] * x + pose[4] * y + pose[7] * z;
    const nz = pose[2] * x + pose[5] * y + pose[8] * z;
    const facing = -(nx * view.sight[0] + ny * view.sight[1] + nz * view.sight[2]);
    const leftward = -(nx * view.right[0] + ny * view.right[1]);
    return 0.5 + 0.3 * Math.max(0, nz) + 0.22 * Math.max(0, facing) + 0.12 * leftward;
  }

  // What the robot hides of the floor, seen from straight above.
  shadow(raster, view, poses, ground) {
    for (const solid of this.solids) {
      const { pose, mesh } = this.placed(solid, poses);
      for (const [points] of mesh) {
        const corners = [];
        for (let k = 0; k < 9; k += 3)
          corners.push(view.project(pose[0] * points[k] + pose[3] * points[k + 1] + pose[6] * points[k + 2] + pose[9],
                                    pose[1] * points[k] + pose[4] * points[k + 1] + pose[7] * points[k + 2] + pose[10], ground));
        if (corners.some((corner) => corner[2] < NEAREST * view.distance)) continue;
        raster.triangle(corners[0], corners[1], corners[2], [1, 1, 1], [0, 0, 0], 1);
        raster.triangle(corners[0], corners[2], corners[1], [1, 1, 1], [0, 0, 0], 1);
      }
    }
  }
}
