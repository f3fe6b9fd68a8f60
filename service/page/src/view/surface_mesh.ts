// An object that changes: soft, sculpted or extruded. Its buffers are used again and grow when they must.
import {
  BufferAttribute, BufferGeometry, DynamicDrawUsage, Mesh, MeshStandardMaterial, Sphere, Vector3, type Material,
} from 'three';
import { fit } from '../decode';
import type { Shape } from '../types';
import { splitAtCreases, vertexNormals, type Split } from './creases';
import { paintFromBefore, paintFromShapes, type Paint, type Painted } from './paint';

const kResplit = 12000; // triangles up to which creases are looked for in every update
const kGrowth = 1.3;

// What the messages said last: `triangles` stay when one has none.
interface Surface {
  positions: Float32Array;
  triangles: Uint32Array;
}

// The triangles in the order in which they are drawn: by part.
interface Wiring {
  triangles: Uint32Array;
  parts: Uint16Array;
}

export class SurfaceMesh {
  readonly mesh: Mesh<BufferGeometry, Material[]>;
  private surface: Surface | null = null;
  private painted: Painted | null = null; // what colours and parts belong to
  private wiring: Wiring = { triangles: new Uint32Array(), parts: new Uint16Array() };
  private split: Split | null = null;
  private changed = false;
  private rewired = false; // other triangles, or other parts to paint from

  // `plain`: of an object without parts.
  constructor(private shapes: Shape[], materials: Material[], private readonly plain: MeshStandardMaterial) {
    this.mesh = new Mesh(new BufferGeometry(), materials);
    this.mesh.castShadow = true;
    this.mesh.receiveShadow = true;
    this.mesh.visible = false;
    this.setParts(shapes, materials);
  }

  setParts(shapes: Shape[], materials: Material[]): void {
    this.shapes = shapes;
    this.mesh.material = materials.length > 0 ? materials : [this.plain];
    this.painted = null;
    this.rewired = true;
    this.changed = this.surface !== null;
  }

  set(positions: Float32Array, triangles: Uint32Array | null): void {
    const before = this.surface?.triangles ?? null;
    if (triangles === null && before === null) return; // the beginning was missed: there is nothing to draw yet
    const next = { positions, triangles: triangles ?? before! };
    const rewired = triangles !== null || positions.length !== this.surface?.positions.length;
    if (rewired && !fit(positions, next.triangles)) return; // does not belong together
    this.rewired ||= rewired;
    this.surface = next;
    this.changed = true;
  }

  // Brings the buffers up to date, once per drawn frame.
  update(): void {
    if (!this.changed || this.surface === null) return;
    const { positions, triangles } = this.surface;
    if (this.rewired || this.painted === null) {
      const paint = this.painted
        ? paintFromBefore(this.painted, positions, triangles)
        : paintFromShapes(this.shapes, positions, triangles);
      this.painted = { positions, triangles, paint };
      this.wiring = { triangles: sorted(triangles, paint.parts), parts: paint.parts.slice().sort() };
      this.split = null;
    } else {
      this.painted.positions = positions;
    }
    if (this.split === null || triangles.length / 3 <= kResplit) {
      this.split = splitAtCreases(positions, this.wiring.triangles);
      this.fill(this.split, this.painted.paint.colours);
    }
    this.move(this.split, positions);
    this.rewired = false;
    this.changed = false;
    this.mesh.visible = true;
  }

  dispose(): void {
    this.mesh.geometry.dispose();
  }

  // Index, groups and colours.
  private fill(split: Split, colours: Paint['colours']): void {
    const { mesh } = this;
    const { parts } = this.wiring;
    const vertices = split.source.length;
    const room = (name: string, n: number) => (mesh.geometry.getAttribute(name)?.count ?? 0) >= n;
    const index = mesh.geometry.getIndex();
    const coloured = colours !== null;
    if (!room('position', vertices) || (index?.count ?? 0) < split.index.length || (coloured && !room('color', 1))) {
      mesh.geometry.dispose();
      mesh.geometry = roomFor(Math.ceil(kGrowth * vertices), Math.ceil(kGrowth * split.index.length), coloured);
    }
    const geometry = mesh.geometry;
    upload(geometry.getIndex()!, split.index.length, (array) => array.set(split.index));
    geometry.setDrawRange(0, split.index.length);
    if (colours !== null) {
      upload(geometry.getAttribute('color') as BufferAttribute, 4 * vertices, (array) => {
        for (let i = 0; i < vertices; ++i) {
          const from = 4 * split.source[i]!;
          array.set(colours.subarray(from, from + 4), 4 * i);
        }
      });
    }
    geometry.clearGroups();
    for (let t = 0; t < parts.length; ) {
      let end = t + 1;
      while (end < parts.length && parts[end] === parts[t]) ++end;
      geometry.addGroup(3 * t, 3 * (end - t), Math.min(parts[t]!, mesh.material.length - 1));
      t = end;
    }
  }

  // Vertices and normals.
  private move(split: Split, positions: Float32Array): void {
    const { geometry } = this.mesh;
    const vertices = split.source.length;
    const position = geometry.getAttribute('position') as BufferAttribute;
    upload(position, 3 * vertices, (array) => {
      for (let i = 0; i < vertices; ++i) {
        const from = 3 * split.source[i]!;
        array[3 * i] = positions[from]!;
        array[3 * i + 1] = positions[from + 1]!;
        array[3 * i + 2] = positions[from + 2]!;
      }
    });
    const source = position.array as Float32Array;
    upload(geometry.getAttribute('normal') as BufferAttribute, 3 * vertices, (array) => {
      vertexNormals(source, split.index, vertices, array as Float32Array);
    });
    geometry.boundingSphere = sphereAround(source, vertices);
  }
}

function sphereAround(positions: Float32Array, vertices: number): Sphere {
  const low = [Infinity, Infinity, Infinity] as [number, number, number];
  const high = [-Infinity, -Infinity, -Infinity] as [number, number, number];
  for (let i = 0; i < 3 * vertices; ++i) {
    const axis = (i % 3) as 0 | 1 | 2;
    low[axis] = Math.min(low[axis], positions[i]!);
    high[axis] = Math.max(high[axis], positions[i]!);
  }
  const centre = new Vector3(...low).add(new Vector3(...high)).multiplyScalar(0.5);
  return new Sphere(centre, centre.distanceTo(new Vector3(...high)));
}

function roomFor(vertices: number, corners: number, coloured: boolean): BufferGeometry {
  const geometry = new BufferGeometry();
  const dynamic = (attribute: BufferAttribute) => attribute.setUsage(DynamicDrawUsage);
  geometry.setAttribute('position', dynamic(new BufferAttribute(new Float32Array(3 * vertices), 3)));
  geometry.setAttribute('normal', dynamic(new BufferAttribute(new Float32Array(3 * vertices), 3)));
  if (coloured) geometry.setAttribute('color', dynamic(new BufferAttribute(new Uint8Array(4 * vertices), 4, true)));
  geometry.setIndex(dynamic(new BufferAttribute(new Uint32Array(corners), 1)));
  return geometry;
}

function upload(attribute: BufferAttribute, n: number, write: (array: BufferAttribute['array']) => void): void {
  write(attribute.array);
  attribute.clearUpdateRanges();
  attribute.addUpdateRange(0, n);
  attribute.needsUpdate = true;
}

// The triangles in the order of their parts, each part's in the order in which they came.
function sorted(triangles: Uint32Array, parts: Uint16Array): Uint32Array {
  if (parts.every((part) => part === parts[0])) return triangles;
  const order = Array.from(parts.keys()).sort((a, b) => parts[a]! - parts[b]! || a - b);
  const out = new Uint32Array(triangles.length);
  order.forEach((t, i) => out.set(triangles.subarray(3 * t, 3 * t + 3), 3 * i));
  return out;
}
