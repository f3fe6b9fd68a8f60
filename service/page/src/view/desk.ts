// The desk: a fine grid of 10 mm with lines every 50 mm that fades out, the shadow on it, and rulers in millimetres.
import {
  BufferGeometry, CanvasTexture, CircleGeometry, Color, Float32BufferAttribute, Group, LineBasicMaterial,
  LineSegments, Mesh, MeshBasicMaterial, PlaneGeometry, ShaderMaterial, ShadowMaterial,
} from 'three';
import type { Palette } from './palette';

const kRadius = 0.7; // of what is drawn
const kRuler = 0.11; // of the rulers from the middle
const kRulerEnd = 0.1;

const kVertex = /* glsl */ `
varying vec2 v_place;
void main() {
  v_place = position.xy;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;

const kFragment = /* glsl */ `
uniform vec3 desk;
uniform vec3 fine;
uniform vec3 coarse;
uniform vec3 shade;
uniform float shadeOpacity;
uniform float foot;
varying vec2 v_place;
// How much of this pixel a grid of lines covers; nothing where the lines would be too dense to be seen.
float grid(float spacing, float width) {
  vec2 p = v_place / spacing;
  vec2 size = fwidth(p);
  vec2 line = 1.0 - clamp(abs(fract(p - 0.5) - 0.5) / size - 0.5 * (width - 1.0), 0.0, 1.0);
  vec2 seen = 1.0 - smoothstep(0.12, 0.4, size);
  return max(line.x * seen.x, line.y * seen.y);
}
void main() {
  float r = length(v_place);
  vec3 colour = mix(desk, fine, grid(0.01, 1.0));
  colour = mix(colour, coarse, 0.8 * grid(0.05, 1.2));
  float under = 1.0 - smoothstep(0.75, 1.55, r / foot); // the foot keeps light away from the desk around it
  colour = mix(colour, shade, shadeOpacity * under * under);
  gl_FragColor = vec4(colour, 1.0 - smoothstep(0.14, 0.42, r));
  #include <colorspace_fragment>
}`;

export class Desk {
  readonly group = new Group();
  private readonly sheet: ShaderMaterial;
  private readonly shadow = new ShadowMaterial({ transparent: true });
  private readonly ticks = new LineBasicMaterial({ color: 0, toneMapped: false, transparent: true, opacity: 0.75 });
  private readonly labels: MeshBasicMaterial[] = [];

  constructor() {
    this.sheet = new ShaderMaterial({
      vertexShader: kVertex,
      fragmentShader: kFragment,
      uniforms: {
        desk: { value: new Color() },
        fine: { value: new Color() },
        coarse: { value: new Color() },
        shade: { value: new Color(0x05080c) },
        shadeOpacity: { value: 0.2 },
        foot: { value: 0.08 },
      },
      transparent: true,
      depthWrite: false,
    });
    const sheet = new Mesh(new CircleGeometry(kRadius, 64), this.sheet);
    sheet.renderOrder = -3;
    const shadow = new Mesh(new CircleGeometry(0.2, 48), this.shadow);
    shadow.position.z = 2e-4;
    shadow.renderOrder = -2;
    shadow.receiveShadow = true;
    this.group.add(sheet, shadow, this.rulers());
  }

  // Where the base stands: height of the desk and radius of the foot.
  place(z: number, foot: number): void {
    this.group.position.z = z;
    this.sheet.uniforms['foot']!.value = foot;
  }

  setPalette(palette: Palette): void {
    const set = (name: string, colour: Color) => (this.sheet.uniforms[name]!.value as Color).copy(colour);
    set('desk', palette.desk);
    set('fine', palette.gridFine);
    set('coarse', palette.gridCoarse);
    this.sheet.uniforms['shadeOpacity']!.value = 1.6 * palette.shadow;
    this.shadow.opacity = palette.shadow;
    this.ticks.color.copy(palette.label);
    for (const label of this.labels) label.color.copy(palette.label);
  }

  // One along x in front of the base, one along y to its right.
  private rulers(): Group {
    const group = new Group();
    const lines: number[] = [];
    for (const along of ['x', 'y'] as const) {
      const put = (t: number, off: number): [number, number, number] =>
        along === 'x' ? [t, -kRuler - off, 0] : [kRuler + off, t, 0];
      lines.push(...put(-kRulerEnd, 0), ...put(kRulerEnd, 0));
      for (let mm = -100; mm <= 100; mm += 5) {
        const size = mm % 50 === 0 ? 0.005 : mm % 10 === 0 ? 0.0032 : 0.0018;
        lines.push(...put(mm / 1000, 0), ...put(mm / 1000, size));
        if (mm % 50 !== 0) continue;
        const label = this.label(mm === 100 ? `${along} 100 mm` : `${mm < 0 ? '\u2212' : ''}${Math.abs(mm)}`);
        const width = label.geometry.parameters.width;
        label.position.set(...put(mm / 1000, along === 'x' ? 0.011 : 0.007 + 0.5 * width));
        group.add(label);
      }
    }
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new Float32BufferAttribute(lines, 3));
    const ruler = new LineSegments(geometry, this.ticks);
    ruler.renderOrder = -1;
    group.add(ruler);
    group.position.z = 4e-4;
    return group;
  }

  // Text that lies on the desk, to be read from the front.
  private label(text: string): Mesh<PlaneGeometry> {
    const canvas = document.createElement('canvas');
    const draw = canvas.getContext('2d');
    const font = '500 44px system-ui, -apple-system, "Segoe UI", sans-serif';
    if (draw !== null) {
      draw.font = font;
      canvas.width = Math.ceil(draw.measureText(text).width) + 16;
      canvas.height = 64;
      draw.font = font;
      draw.fillStyle = '#fff';
      draw.textAlign = 'center';
      draw.textBaseline = 'middle';
      draw.fillText(text, canvas.width / 2, canvas.height / 2 + 2);
    }
    const map = new CanvasTexture(canvas);
    map.anisotropy = 8;
    const material = new MeshBasicMaterial({ map, transparent: true, depthWrite: false, toneMapped: false });
    this.labels.push(material);
    const height = 0.0105;
    const mesh = new Mesh(new PlaneGeometry((height * canvas.width) / canvas.height, height), material);
    mesh.renderOrder = -1;
    return mesh;
  }
}
