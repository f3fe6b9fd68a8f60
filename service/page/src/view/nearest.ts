// The nearest of many points, by a grid of cells: for colours of surfaces whose vertices are not those of the file.
export class Nearest {
  private readonly cells = new Map<number, number[]>();
  private readonly cell: number;
  private readonly low: [number, number, number] = [Infinity, Infinity, Infinity];
  private readonly most: number; // rings of cells around a place that may hold points

  // `points`: 3 numbers each.
  constructor(private readonly points: Float32Array) {
    const high: [number, number, number] = [-Infinity, -Infinity, -Infinity];
    for (let i = 0; i < points.length; ++i) {
      const axis = (i % 3) as 0 | 1 | 2;
      this.low[axis] = Math.min(this.low[axis], points[i]!);
      high[axis] = Math.max(high[axis], points[i]!);
    }
    const extent = Math.max(high[0] - this.low[0], high[1] - this.low[1], high[2] - this.low[2], 1e-6);
    // A surface of n points crosses about n cells of this size.
    this.cell = Math.max(extent / Math.max(1, Math.sqrt(points.length / 9)), extent / 1000);
    this.most = Math.ceil(extent / this.cell) + 1;
    for (let i = 0; i < points.length / 3; ++i) {
      const key = this.key(this.index(3 * i, 0), this.index(3 * i, 1), this.index(3 * i, 2));
      const list = this.cells.get(key);
      if (list === undefined) this.cells.set(key, [i]);
      else list.push(i);
    }
  }

  // Index of the point nearest to [x, y, z]; -1 if there are none.
  find(x: number, y: number, z: number): number {
    if (this.points.length === 0) return -1;
    const inside = (value: number, low: number) =>
      Math.min(this.most, Math.max(-1, Math.floor((value - low) / this.cell)));
    const [cx, cy, cz] = [inside(x, this.low[0]), inside(y, this.low[1]), inside(z, this.low[2])];
    let best = -1;
    let least = Infinity;
    for (let ring = 0; ring <= 2 * this.most + 2; ++ring) {
      // A point in a further ring is at least this far away.
      const far = Math.max(0, ring - 1) * this.cell;
      if (best >= 0 && far * far > least) break;
      for (let i = cx - ring; i <= cx + ring; ++i) {
        for (let j = cy - ring; j <= cy + ring; ++j) {
          const rim = Math.abs(i - cx) === ring || Math.abs(j - cy) === ring;
          for (let k = cz - ring; k <= cz + ring; k += rim || ring === 0 ? 1 : 2 * ring) {
            for (const p of this.cells.get(this.key(i, j, k)) ?? []) {
              const dx = this.points[3 * p]! - x;
              const dy = this.points[3 * p + 1]! - y;
              const dz = this.points[3 * p + 2]! - z;
              const d = dx * dx + dy * dy + dz * dz;
              if (d >= least) continue;
              least = d;
              best = p;
            }
          }
        }
      }
    }
    return best;
  }

  private index(at: number, axis: 0 | 1 | 2): number {
    return Math.floor((this.points[at + axis]! - this.low[axis]) / this.cell);
  }

  private key(i: number, j: number, k: number): number {
    return ((i + 4) * 4099 + (j + 4)) * 4099 + (k + 4);
  }
}
