// The middle of a road between two walls, from the scene's file: what a driver sees.
import { readFileSync } from 'node:fs';

function glb(path) {
  const file = readFileSync(path);
  const jsonBytes = file.readUInt32LE(12);
  const json = JSON.parse(file.subarray(20, 20 + jsonBytes).toString('utf8'));
  return { json, binary: file.subarray(20 + jsonBytes + 8) };
}

// Positions of a node's first primitive, base frame: (x, y, z)_B = (x, -z, y)_glTF.
function positions({ json, binary }, name) {
  const node = json.nodes.find((candidate) => candidate.name === name);
  const accessor = json.accessors[json.meshes[node.mesh].primitives[0].attributes.POSITION];
  const view = json.bufferViews[accessor.bufferView];
  const [tx, ty, tz] = node.translation ?? [0, 0, 0];
  const begin = (view.byteOffset ?? 0) + (accessor.byteOffset ?? 0);
  const stride = view.byteStride ?? 12;
  return Array.from({ length: accessor.count }, (_, i) => {
    const at = begin + i * stride;
    const [x, y, z] = [0, 4, 8].map((offset) => binary.readFloatLE(at + offset));
    return [x + tx, -(z + tz), y + ty];
  });
}

// Points of the middle line, in order, closed: for each of the inner wall the point half-way to the nearest of the outer.
export function middleLine(path) {
  const file = glb(path);
  const flat = (name) => {
    const seen = new Map();
    for (const [x, y] of positions(file, name)) seen.set(`${Math.round(x * 1e4)},${Math.round(y * 1e4)}`, [x, y]);
    return [...seen.values()];
  };
  const inner = flat('inner wall');
  const outer = flat('outer wall');
  const nearest = (p, points) =>
    points.reduce((best, q) => (Math.hypot(q[0] - p[0], q[1] - p[1]) < Math.hypot(best[0] - p[0], best[1] - p[1]) ? q : best));
  const middle = inner.map((p) => {
    const q = nearest(p, outer);
    return [(p[0] + q[0]) / 2, (p[1] + q[1]) / 2];
  });
  // From one to its nearest neighbour that was not visited yet.
  const line = [middle.pop()];
  while (middle.length > 0) {
    const next = nearest(line.at(-1), middle);
    middle.splice(middle.indexOf(next), 1);
    const [dx, dy] = [next[0] - line.at(-1)[0], next[1] - line.at(-1)[1]];
    if (Math.hypot(dx, dy) > 0.0015) line.push(next);
  }
  return line;
}

// Steers by pure pursuit: the stick (x right, y ahead; -1 ... 1) for a car at a place with a heading.
export function steer(line, car, ahead_m = 0.012) {
  const [x, y] = car.position;
  let best = 0;
  line.forEach((p, i) => {
    if (Math.hypot(p[0] - x, p[1] - y) < Math.hypot(line[best][0] - x, line[best][1] - y)) best = i;
  });
  const neighbour = line[(best + 1) % line.length];
  const along = (neighbour[0] - line[best][0]) * Math.cos(car.heading) + (neighbour[1] - line[best][1]) * Math.sin(car.heading);
  const step = along >= 0 ? 1 : line.length - 1;
  let i = best;
  for (let n = 0; n < line.length && Math.hypot(line[i][0] - x, line[i][1] - y) < ahead_m; ++n) i = (i + step) % line.length;
  const bearing = Math.atan2(line[i][1] - y, line[i][0] - x) - car.heading;
  const turn = Math.atan2(Math.sin(bearing), Math.cos(bearing));
  return { x: Math.max(-1, Math.min(1, -2.2 * turn)), y: Math.abs(turn) > 0.5 ? 0.25 : 0.55 };
}
