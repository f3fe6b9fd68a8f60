// The car of a race: it lives in the simulation, only its place and heading are known here. A ring shows that it slides.
import {
  BoxGeometry, BufferGeometry, CylinderGeometry, Group, Mesh, MeshBasicMaterial, MeshStandardMaterial, TorusGeometry,
} from 'three';
import type { Vehicle } from '../types';
import type { Palette } from './palette';

const mm = 1e-3;

export class Car {
  readonly group = new Group();
  private readonly paint = new MeshStandardMaterial({ color: '#e4352b', roughness: 0.35 });
  private readonly dark = new MeshStandardMaterial({ color: '#15181d', roughness: 0.6 });
  private readonly glass = new MeshStandardMaterial({ color: '#27333f', roughness: 0.12, metalness: 0.3 });
  private readonly rim = new MeshStandardMaterial({ color: '#d8dee6', roughness: 0.3, metalness: 0.8 });
  private readonly slide = new MeshBasicMaterial({ transparent: true, opacity: 0.85, toneMapped: false });
  private readonly ring = new Mesh(new TorusGeometry(5.6 * mm, 0.28 * mm, 10, 56), this.slide);

  // Heading 0: along +x; 7.2 mm long.
  constructor() {
    const box = (l: number, w: number, h: number, x: number, z: number, material: MeshStandardMaterial) =>
      this.add(new BoxGeometry(l * mm, w * mm, h * mm).translate(x * mm, 0, z * mm), material);
    box(6.6, 2.5, 0.75, 0, 0.85, this.paint); // floor
    box(2.0, 1.5, 0.5, 2.5, 1.25, this.paint); // nose
    box(0.5, 3.4, 0.3, 3.35, 0.6, this.paint); // front wing
    box(2.6, 2.1, 0.7, -0.7, 1.5, this.paint); // body behind the nose
    this.add(taper(new BoxGeometry(2.2 * mm, 1.7 * mm, 0.75 * mm).translate(-0.5 * mm, 0, 2.15 * mm)), this.glass);
    box(0.7, 3.3, 0.22, -3.2, 2.65, this.paint); // rear wing
    box(0.4, 0.3, 0.9, -3.1, 2.1, this.dark);
    for (const x of [2.15, -2.15]) {
      for (const side of [-1, 1]) {
        const tyre = new CylinderGeometry(0.95 * mm, 0.95 * mm, 0.85 * mm, 20);
        const hub = new CylinderGeometry(0.45 * mm, 0.45 * mm, 0.9 * mm, 14);
        this.add(tyre.translate(x * mm, side * 1.55 * mm, 0.95 * mm), this.dark);
        this.add(hub.translate(x * mm, side * 1.56 * mm, 0.95 * mm), this.rim);
      }
    }
    this.ring.position.z = 0.5 * mm;
    this.group.add(this.ring);
    this.group.visible = false;
  }

  place(vehicle: Vehicle | null): void {
    this.group.visible = vehicle !== null;
    if (vehicle === null) return;
    this.group.position.set(...vehicle.position);
    this.group.rotation.z = vehicle.heading;
    this.ring.visible = vehicle.sliding;
  }

  setPalette(palette: Palette): void {
    this.slide.color.copy(palette.proxy);
  }

  private add(geometry: BufferGeometry, material: MeshStandardMaterial): void {
    const mesh = new Mesh(geometry, material);
    mesh.castShadow = true;
    this.group.add(mesh);
  }
}

// A cabin is narrower above.
function taper(geometry: BufferGeometry): BufferGeometry {
  const position = geometry.getAttribute('position');
  for (let i = 0; i < position.count; ++i) {
    if (position.getZ(i) < 2.2 * mm) continue;
    position.setXY(i, -0.5 * mm + 0.6 * (position.getX(i) + 0.5 * mm), 0.72 * position.getY(i));
  }
  geometry.computeVertexNormals();
  return geometry;
}
