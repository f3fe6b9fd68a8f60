// What there is to touch: the parts of a scene as they are loaded, and the objects that have changed since.
import {
  BufferAttribute, BufferGeometry, DoubleSide, Group, Mesh, MeshStandardMaterial, Raycaster, Vector3,
} from 'three';
import type { SceneMessage, Shape, Surface } from '../types';
import { SurfaceMesh } from './surface_mesh';

interface Part {
  shape: Shape;
  object: number;
  mesh: Mesh<BufferGeometry, MeshStandardMaterial>;
}

interface Body {
  group: Group; // at the object's pose
  surface: SurfaceMesh | null; // instead of its parts
}

export class SceneParts {
  readonly group = new Group();
  private scene: SceneMessage | null = null;
  private readonly parts = new Map<number, Part>();
  private readonly bodies = new Map<number, Body>();
  private readonly plain = new MeshStandardMaterial({ color: '#b8bfc8', roughness: 0.6, side: DoubleSide });

  // `hidden`: which parts are not drawn, by their vertices; only asked for those that cannot be touched.
  constructor(private readonly hidden: (shape: Shape) => boolean) {}

  setScene(scene: SceneMessage): void {
    if (scene.number !== this.scene?.number) this.clear();
    this.scene = scene;
  }

  get number(): number {
    return this.scene?.number ?? -1;
  }

  // What an object is called: the name of its first part.
  name(object: number): string {
    return this.scene?.parts.find((part) => part.object === object)?.name ?? '';
  }

  add(shape: Shape): boolean {
    const about = this.scene?.parts[shape.part];
    if (shape.scene !== this.number || about === undefined) return false;
    this.drop(shape.part);
    const mesh = new Mesh(geometryOf(shape), materialOf(shape));
    mesh.castShadow = true;
    mesh.receiveShadow = true;
    mesh.visible = about.object >= 0 || !this.hidden(shape);
    this.parts.set(shape.part, { shape, object: about.object, mesh });
    if (about.object < 0) {
      this.group.add(mesh);
      return true;
    }
    const body = this.body(about.object);
    body.group.add(mesh);
    if (body.surface !== null) {
      body.surface.setParts(...this.partsOf(about.object));
      this.showParts(about.object, body);
    }
    return true;
  }

  setSurface(surface: Surface): boolean {
    if (surface.scene !== this.number) return false;
    const body = this.body(surface.object);
    const [w, x, y, z] = surface.rotation;
    body.group.quaternion.set(x, y, z, w).normalize();
    body.group.position.set(...surface.translation);
    if (surface.positions !== null) {
      if (body.surface === null) {
        body.surface = new SurfaceMesh(...this.partsOf(surface.object), this.plain);
        body.group.add(body.surface.mesh);
      }
      body.surface.set(surface.positions, surface.triangles);
    }
    return true;
  }

  // Before drawing.
  update(): void {
    for (const [object, body] of this.bodies) {
      body.surface?.update();
      this.showParts(object, body);
    }
  }

  // Again for all: the base is another one.
  hideAgain(): void {
    for (const part of this.parts.values()) if (part.object < 0) part.mesh.visible = !this.hidden(part.shape);
  }

  // Height of what lies on the vertical line through x, y; null if nothing does.
  heightAt(x: number, y: number): number | null {
    this.update();
    this.group.updateMatrixWorld(true);
    const hits = new Raycaster(new Vector3(x, y, 0.5), new Vector3(0, 0, -1), 0, 1).intersectObject(this.group, true);
    return hits.find((hit) => hit.object.visible)?.point.z ?? null;
  }

  private body(object: number): Body {
    let body = this.bodies.get(object);
    if (body === undefined) {
      body = { group: new Group(), surface: null };
      this.bodies.set(object, body);
      this.group.add(body.group);
    }
    return body;
  }

  private partsOf(object: number): [Shape[], MeshStandardMaterial[]] {
    const parts = [...this.parts.values()].filter((part) => part.object === object);
    return [parts.map((part) => part.shape), parts.map((part) => part.mesh.material)];
  }

  private showParts(object: number, body: Body): void {
    const visible = !(body.surface?.mesh.visible ?? false);
    for (const part of this.parts.values()) if (part.object === object) part.mesh.visible = visible;
  }

  private drop(index: number): void {
    const part = this.parts.get(index);
    if (part === undefined) return;
    part.mesh.removeFromParent();
    part.mesh.geometry.dispose();
    part.mesh.material.dispose();
    this.parts.delete(index);
  }

  private clear(): void {
    for (const index of [...this.parts.keys()]) this.drop(index);
    for (const body of this.bodies.values()) body.surface?.dispose();
    this.bodies.clear();
    this.group.clear();
  }
}

function geometryOf(shape: Shape): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(shape.positions, 3));
  geometry.setAttribute('normal', new BufferAttribute(shape.normals, 3));
  if (shape.colours !== null) geometry.setAttribute('color', new BufferAttribute(shape.colours, 4, true));
  geometry.setIndex(new BufferAttribute(shape.triangles, 1));
  return geometry;
}

function materialOf(shape: Shape): MeshStandardMaterial {
  const material = new MeshStandardMaterial({
    roughness: Math.min(1, Math.max(0.25, shape.roughness)),
    vertexColors: shape.colours !== null,
    side: DoubleSide, // sheets are touched, and seen, from both sides
  });
  if (shape.colours === null) material.color.setRGB(...shape.colour); // linear, as three.js has it
  return material;
}
