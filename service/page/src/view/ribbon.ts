// A line of a given width in pixels of the page, whatever its distance, with an opacity at every point. (Lines of WebGL
// are one device pixel wide.)
import {
  BufferAttribute, BufferGeometry, Color, DoubleSide, DynamicDrawUsage, Mesh, ShaderMaterial, type Vector2,
} from 'three';

const kVertex = /* glsl */ `
attribute vec3 tangent;
attribute vec2 edge; // side, -1 or 1; opacity
uniform vec2 resolution;
uniform float width;
varying vec2 v_edge;
void main() {
  vec4 a = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  vec4 b = projectionMatrix * modelViewMatrix * vec4(position + tangent, 1.0);
  vec2 along = (b.xy / b.w - a.xy / a.w) * resolution;
  float n = length(along);
  vec2 across = n > 1e-7 ? vec2(-along.y, along.x) / n : vec2(1.0, 0.0);
  a.xy += across * edge.x * (width + 1.0) / resolution * a.w;
  v_edge = edge;
  gl_Position = a;
}`;

const kFragment = /* glsl */ `
uniform vec3 colour;
uniform float width;
uniform float opacity;
varying vec2 v_edge;
void main() {
  float pixels = (1.0 - abs(v_edge.x)) * 0.5 * (width + 1.0); // to the edge
  gl_FragColor = vec4(colour, opacity * v_edge.y * clamp(pixels, 0.0, 1.0));
  #include <colorspace_fragment>
}`;

export class Ribbon extends Mesh<BufferGeometry, ShaderMaterial> {
  private readonly vertices: Float32Array;
  private readonly tangents: Float32Array;
  private readonly edges: Float32Array;

  // `resolution` is shared by all ribbons: the canvas in pixels of the page. `step`: length of the tangents, small
  // against the curve.
  constructor(readonly capacity: number, width: number, resolution: { value: Vector2 }, private readonly step = 1e-4) {
    const geometry = new BufferGeometry();
    const vertices = new Float32Array(6 * capacity);
    const tangents = new Float32Array(6 * capacity);
    const edges = new Float32Array(4 * capacity);
    const index = new Uint32Array(6 * Math.max(0, capacity - 1));
    for (let i = 0; i < capacity - 1; ++i) {
      const a = 2 * i;
      index.set([a, a + 1, a + 2, a + 2, a + 1, a + 3], 6 * i);
    }
    const dynamic = (array: Float32Array, size: number) => new BufferAttribute(array, size).setUsage(DynamicDrawUsage);
    geometry.setAttribute('position', dynamic(vertices, 3));
    geometry.setAttribute('tangent', dynamic(tangents, 3));
    geometry.setAttribute('edge', dynamic(edges, 2));
    geometry.setIndex(new BufferAttribute(index, 1));
    geometry.setDrawRange(0, 0);
    const material = new ShaderMaterial({
      vertexShader: kVertex,
      fragmentShader: kFragment,
      uniforms: { resolution, width: { value: width }, opacity: { value: 1 }, colour: { value: new Color() } },
      side: DoubleSide, // which side faces the eye depends on the direction on the screen
      transparent: true,
      depthWrite: false,
    });
    super(geometry, material);
    this.vertices = vertices;
    this.tangents = tangents;
    this.edges = edges;
    this.frustumCulled = false; // its bounds change all the time, and it is always near the middle
  }

  setColour(colour: Color): void {
    (this.material.uniforms['colour']!.value as Color).copy(colour);
  }

  setOpacity(opacity: number): void {
    this.material.uniforms['opacity']!.value = opacity;
  }

  // `points`: 3 numbers each. Where the opacity is 0 the line is interrupted.
  setPoints(points: Float32Array, opacities: Float32Array, count: number): void {
    const n = Math.min(count, this.capacity);
    for (let i = 0; i < n; ++i) {
      const before = 3 * Math.max(0, i - 1);
      const after = 3 * Math.min(n - 1, i + 1);
      let tx = points[after]! - points[before]!;
      let ty = points[after + 1]! - points[before + 1]!;
      let tz = points[after + 2]! - points[before + 2]!;
      const scale = this.step / (Math.hypot(tx, ty, tz) || 1);
      tx *= scale;
      ty *= scale;
      tz *= scale;
      for (let side = 0; side < 2; ++side) {
        const v = 3 * (2 * i + side);
        this.vertices.set([points[3 * i]!, points[3 * i + 1]!, points[3 * i + 2]!], v);
        this.tangents.set([tx, ty, tz], v);
        this.edges.set([2 * side - 1, opacities[i]!], 2 * (2 * i + side));
      }
    }
    this.geometry.setDrawRange(0, 6 * Math.max(0, n - 1));
    for (const name of ['position', 'tangent', 'edge']) {
      const attribute = this.geometry.getAttribute(name) as BufferAttribute;
      attribute.clearUpdateRanges();
      attribute.addUpdateRange(0, 2 * n * attribute.itemSize);
      attribute.needsUpdate = true;
    }
  }
}
