// The renderer and what never changes: background, desk, lights. Draws on request.
import {
  BufferGeometry, Color, DirectionalLight, Float32BufferAttribute, HemisphereLight, Mesh, MeshBasicMaterial,
  NeutralToneMapping, PCFShadowMap, PlaneGeometry, PMREMGenerator, Scene, ShaderMaterial, Vector2, WebGLRenderer,
  type PerspectiveCamera,
} from 'three';
import { Desk } from './desk';
import type { Palette } from './palette';

const kPixelRatios = [2, 1, 1, 0.75, 0.5]; // at most, for each step of quality down
const kNoShadows = 2; // from this step on
const kSoftware = 3; // where a processor draws: without reflections as well, which take it seconds to prepare
const kFill = 0.95; // light from all sides ...
const kPlainFill = 2.2; // ... and where nothing reflects the studio
const kSlow_ms = 45; // frames that wait longer than this ...
const kPatience_ms = 1000; // ... for so long in all cost a step of quality
const kRecovers = 240; // frames in time that bring it back ...
const kTwice = 2; // ... and twice as many each time that it was lost again
const kHidden_ms = 1000; // a longer wait: the page was not shown

// Whether a processor draws instead of a graphics card.
function drawsInSoftware(): boolean {
  const probe = document.createElement('canvas').getContext('webgl2');
  const info = probe?.getExtension('WEBGL_debug_renderer_info');
  const name = info ? String(probe!.getParameter(info.UNMASKED_RENDERER_WEBGL)) : '';
  probe?.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|softpipe|software/i.test(name);
}

// One triangle over everything: a vertical gradient, with a little noise against bands.
function sky(): Mesh<BufferGeometry, ShaderMaterial> {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new Float32BufferAttribute([-1, -1, 1, 3, -1, 1, -1, 3, 1], 3));
  const material = new ShaderMaterial({
    vertexShader: /* glsl */ `
      varying vec2 v_at;
      void main() { v_at = position.xy; gl_Position = vec4(position.xy, 1.0, 1.0); }`,
    fragmentShader: /* glsl */ `
      uniform vec3 top; uniform vec3 bottom; varying vec2 v_at;
      void main() {
        float t = smoothstep(0.0, 1.0, 0.5 + 0.5 * v_at.y);
        gl_FragColor = vec4(mix(bottom, top, t), 1.0);
        #include <colorspace_fragment>
        gl_FragColor.rgb += (fract(sin(dot(gl_FragCoord.xy, vec2(12.9898, 78.233))) * 43758.5453) - 0.5) / 255.0;
      }`,
    uniforms: { top: { value: new Color() }, bottom: { value: new Color() } },
    depthTest: false,
    depthWrite: false,
  });
  const mesh = new Mesh(geometry, material);
  mesh.frustumCulled = false;
  mesh.renderOrder = -10;
  return mesh;
}

// What shiny things mirror: a dim room with three soft lamps.
function studio(): Scene {
  const room = new Scene();
  room.background = new Color(0.3, 0.32, 0.35);
  const lamp = (strength: number, width: number, height: number, x: number, y: number, z: number) => {
    const material = new MeshBasicMaterial({ color: new Color().setScalar(strength), side: 2 });
    const mesh = new Mesh(new PlaneGeometry(width, height), material);
    mesh.position.set(x, y, z);
    mesh.lookAt(0, 0, 0);
    room.add(mesh);
  };
  lamp(9, 5, 5, -1.5, -1, 5);
  lamp(4, 2, 5, -5, -2, 1.5);
  lamp(2.5, 2, 5, 5, 2, 2);
  return room;
}

export class Stage {
  readonly scene = new Scene();
  readonly desk = new Desk();
  readonly resolution = { value: new Vector2(1, 1) }; // pixels of the page, for ribbons
  private readonly renderer: WebGLRenderer;
  private readonly background = sky();
  private readonly key = new DirectionalLight(0xffffff, 1.7);
  private readonly fill = new HemisphereLight(0xffffff, 0xffffff, kFill);
  private size = new Vector2(1, 1);
  private quality = 0; // steps down
  private full = false; // always all of the detail
  private slow_ms = 0;
  private inTime = 0; // frames since the last slow one
  private recovers = kRecovers;
  private readonly least: number; // steps down to begin with

  // Throws if there is no WebGL 2.
  constructor(canvas: HTMLCanvasElement) {
    const software = drawsInSoftware();
    this.renderer = new WebGLRenderer({ canvas, antialias: !software, powerPreference: 'high-performance' });
    this.least = software ? kSoftware : 0;
    this.quality = this.least;
    this.renderer.toneMapping = NeutralToneMapping;
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = PCFShadowMap;
    this.key.position.set(-0.1, -0.17, 0.5);
    this.key.castShadow = this.quality < kNoShadows;
    this.key.shadow.mapSize.set(2048, 2048);
    this.key.shadow.bias = -4e-4;
    this.key.shadow.normalBias = 6e-4;
    this.key.shadow.radius = 3;
    const box = this.key.shadow.camera;
    [box.left, box.right, box.bottom, box.top, box.near, box.far] = [-0.2, 0.2, -0.2, 0.2, 0.15, 0.9];
    this.scene.add(this.background, this.desk.group, this.key, this.fill);
    if (!software) this.reflect();
    else this.fill.intensity = kPlainFill;
  }

  setPalette(palette: Palette): void {
    (this.background.material.uniforms['top']!.value as Color).copy(palette.skyTop);
    (this.background.material.uniforms['bottom']!.value as Color).copy(palette.skyBottom);
    this.fill.color.copy(palette.sky);
    this.fill.groundColor.copy(palette.ground);
    this.scene.environmentIntensity = palette.environment;
    this.desk.setPalette(palette);
  }

  resize(width: number, height: number): void {
    this.size.set(width, height);
    this.resolution.value.set(width, height);
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, kPixelRatios[this.quality]!));
    this.renderer.setSize(width, height, false);
  }

  render(camera: PerspectiveCamera): void {
    this.renderer.render(this.scene, camera);
  }

  // All of the detail, however slow that is; or as much as the machine can draw.
  setDetail(full: boolean): void {
    this.full = full;
    this.slow_ms = 0;
    if (full && this.scene.environment === null) this.reflect();
    this.setQuality(full ? 0 : this.least);
  }

  // Receives how long a frame had to wait for its turn. On a machine without a graphics card (or with a weak one) fewer
  // pixels, then no shadows: the pen must follow the hand.
  pace(milliseconds: number): void {
    if (this.full || !(milliseconds < kHidden_ms)) return;
    const slow = milliseconds > kSlow_ms;
    this.slow_ms = slow ? this.slow_ms + milliseconds : Math.max(0, this.slow_ms - 2 * kSlow_ms);
    this.inTime = slow ? 0 : this.inTime + 1;
    if (this.inTime > this.recovers && this.quality > this.least) {
      this.inTime = 0;
      this.recovers *= kTwice;
      this.setQuality(this.quality - 1);
    }
    if (this.slow_ms < kPatience_ms || this.quality >= kPixelRatios.length - 1) return;
    this.slow_ms = 0;
    this.setQuality(this.quality + 1);
  }

  private setQuality(quality: number): void {
    this.quality = quality;
    this.key.castShadow = quality < kNoShadows;
    this.resize(this.size.x, this.size.y);
  }

  // After a lost context: the reflections are made on the graphics card and are gone.
  restore(): void {
    if (this.scene.environment !== null) this.reflect();
  }

  private reflect(): void {
    this.fill.intensity = kFill;
    const make = new PMREMGenerator(this.renderer);
    const room = studio();
    this.scene.environment?.dispose();
    this.scene.environment = make.fromScene(room, 0.03, 0.1, 20, { size: 64 }).texture;
    room.traverse((object) => {
      if (!(object instanceof Mesh)) return;
      object.geometry.dispose();
      object.material.dispose();
    });
    make.dispose();
  }
}
