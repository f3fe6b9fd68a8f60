// Shading of a mesh whose vertices are welded: round where it is round, sharp at its edges. Vertices on an edge are
// split, one for each smooth side, and normals are summed up per split vertex.
const kSharp = Math.cos((48 * Math.PI) / 180); // between faces that belong together
const kManyFaces = 24; // a vertex of more is taken as round

// For each triangle: its place in `triangles`, those of its corners in `positions`, and its normal times twice its area.
function eachTriangle(
  positions: Float32Array,
  triangles: Uint32Array,
  visit: (t: number, a: number, b: number, c: number, nx: number, ny: number, nz: number) => void,
): void {
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [3 * triangles[t]!, 3 * triangles[t + 1]!, 3 * triangles[t + 2]!];
    const ux = positions[b]! - positions[a]!;
    const uy = positions[b + 1]! - positions[a + 1]!;
    const uz = positions[b + 2]! - positions[a + 2]!;
    const vx = positions[c]! - positions[a]!;
    const vy = positions[c + 1]! - positions[a + 1]!;
    const vz = positions[c + 2]! - positions[a + 2]!;
    visit(t, a, b, c, uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx);
  }
}

// Unit normals of the triangles, 0 for those without area.
export function faceNormals(positions: Float32Array, triangles: Uint32Array): Float32Array {
  const normals = new Float32Array(triangles.length);
  eachTriangle(positions, triangles, (t, _a, _b, _c, nx, ny, nz) => {
    const n = Math.hypot(nx, ny, nz);
    if (!(n > 1e-16)) return;
    normals[t] = nx / n;
    normals[t + 1] = ny / n;
    normals[t + 2] = nz / n;
  });
  return normals;
}

export interface Split {
  source: Uint32Array; // of each split vertex: the vertex of the mesh
  index: Uint32Array; // the triangles, of split vertices
}

export function splitAtCreases(positions: Float32Array, triangles: Uint32Array): Split {
  const vertices = positions.length / 3;
  const normals = faceNormals(positions, triangles);
  const first = new Uint32Array(vertices + 1); // corners of vertex v: corners[first[v]] to corners[first[v + 1]]
  for (const v of triangles) first[v + 1]! += 1;
  for (let v = 0; v < vertices; ++v) first[v + 1]! += first[v]!;
  const next = first.slice(0, vertices);
  const corners = new Uint32Array(triangles.length);
  for (let c = 0; c < triangles.length; ++c) corners[next[triangles[c]!]!++] = c;

  const close = (a: number, b: number) =>
    normals[a]! * normals[b]! + normals[a + 1]! * normals[b + 1]! + normals[a + 2]! * normals[b + 2]! > kSharp;
  const source = new Uint32Array(triangles.length);
  const index = new Uint32Array(triangles.length);
  const faces: number[] = []; // around one vertex
  let count = 0;
  for (let v = 0; v < vertices; ++v) {
    const from = first[v]!;
    const n = first[v + 1]! - from;
    faces.length = n;
    for (let i = 0; i < n; ++i) faces[i] = corners[from + i]! - (corners[from + i]! % 3);
    let round = true; // most vertices are
    for (let i = 1; round && i < n && n <= kManyFaces; ++i) round = close(faces[0]!, faces[i]!);
    const sides = round ? null : smoothSides(faces, close);
    let most = 0;
    for (let i = 0; i < n; ++i) {
      const side = sides === null ? 0 : sides[i]!;
      most = Math.max(most, side);
      index[corners[from + i]!] = count + side;
    }
    for (let side = 0; n > 0 && side <= most; ++side) source[count++] = v;
  }
  return { source: source.slice(0, count), index };
}

// Numbers from 0 on: faces that are joined by faces with less than an edge between them have the same one. A face
// without area goes with the first.
function smoothSides(faces: number[], close: (a: number, b: number) => boolean): number[] {
  const group = faces.map((_, i) => i);
  for (let i = 1; i < faces.length; ++i) {
    if (!close(faces[i]!, faces[i]!)) group[i] = group[0]!;
    for (let j = 0; j < i; ++j) {
      if (group[i] === group[j] || !close(faces[i]!, faces[j]!)) continue;
      const [keep, drop] = [group[j]!, group[i]!];
      for (let k = 0; k <= i; ++k) if (group[k] === drop) group[k] = keep;
    }
  }
  const names = [...new Set(group)];
  return group.map((g) => names.indexOf(g));
}

// Normals of the vertices, weighted by area, into `out`.
export function vertexNormals(positions: Float32Array, index: Uint32Array, count: number, out: Float32Array): void {
  out.fill(0, 0, 3 * count);
  eachTriangle(positions, index, (_t, a, b, c, nx, ny, nz) => {
    for (const v of [a, b, c]) {
      // In units in which the squares of small triangles do not get lost in 32 bits.
      out[v]! += 1e6 * nx;
      out[v + 1]! += 1e6 * ny;
      out[v + 2]! += 1e6 * nz;
    }
  });
  for (let v = 0; v < 3 * count; v += 3) {
    const n = Math.hypot(out[v]!, out[v + 1]!, out[v + 2]!) || 1;
    out[v]! /= n;
    out[v + 1]! /= n;
    out[v + 2]! /= n;
  }
}
