// A translucent material: clear in the middle, denser towards the rim, with a highlight. For plastic that shows what is
// inside, for the ghost of the pen and for the uncertainty.
import { Color, FrontSide, ShaderMaterial } from 'three';

const kVertex = /* glsl */ `
varying vec3 v_normal;
varying vec3 v_eye;
void main() {
  vec4 p = modelViewMatrix * vec4(position, 1.0);
  v_normal = normalMatrix * normal;
  v_eye = -p.xyz;
  gl_Position = projectionMatrix * p;
}`;

const kFragment = /* glsl */ `
uniform vec3 inner;
uniform vec3 rim;
uniform float innerOpacity;
uniform float rimOpacity;
uniform float sharpness;
uniform float shine;
uniform float strength;
varying vec3 v_normal;
varying vec3 v_eye;
const vec3 kLight = vec3(-0.41, 0.74, 0.53);
void main() {
  vec3 n = normalize(v_normal);
  vec3 eye = normalize(v_eye);
  float edge = pow(1.0 - clamp(dot(n, eye), 0.0, 1.0), sharpness);
  float glint = shine * pow(max(dot(n, normalize(kLight + eye)), 0.0), 60.0);
  float soft = 0.5 + 0.5 * dot(n, kLight);
  vec3 colour = mix(inner * (0.75 + 0.35 * soft), rim, edge) + glint;
  gl_FragColor = vec4(colour, strength * clamp(mix(innerOpacity, rimOpacity, edge) + glint, 0.0, 1.0));
  #include <colorspace_fragment>
}`;

export interface GlassLook {
  innerOpacity: number;
  rimOpacity: number;
  sharpness?: number;
  shine?: number;
}

export class Glass extends ShaderMaterial {
  constructor(look: GlassLook) {
    super({
      vertexShader: kVertex,
      fragmentShader: kFragment,
      uniforms: {
        inner: { value: new Color() },
        rim: { value: new Color() },
        innerOpacity: { value: look.innerOpacity },
        rimOpacity: { value: look.rimOpacity },
        sharpness: { value: look.sharpness ?? 2 },
        shine: { value: look.shine ?? 0 },
        strength: { value: 1 },
      },
      side: FrontSide,
      transparent: true,
      depthWrite: false,
    });
  }

  setColours(inner: Color, rim: Color): void {
    (this.uniforms['inner']!.value as Color).copy(inner);
    (this.uniforms['rim']!.value as Color).copy(rim);
  }

  // 0: not to be seen, 1: as the look says.
  setStrength(strength: number): void {
    this.uniforms['strength']!.value = strength;
  }
}
