// What there is to touch: the parts of a scene as they are loaded, and the objects that have changed since.
import {
  Box3, BufferAttribute, BufferGeometry, DoubleSide, Group, Mesh, MeshStandardMaterial, Raycaster, Vector3,
} from 'three';
import { isSurface } from '../decode';
import type { SceneMessage, Shape, Surface } from '../types';
import { Body, type Parts } from './body';

interface Part {
  shape: Shape;
  object: number;
  mesh: Mesh<BufferGeometry, MeshStandardMaterial>;
}

// Surfaces as a recording has them; those that are missing were as they are loaded.
export interface Replayed {
  scene: number;
  surfaces: readonly Surface[];
}

export class SceneParts {
  readonly group = new Group();
  private scene: SceneMessage | null = null;
  private readonly parts = new Map<number, Part>();
  private readonly bodies = new Map<number, Body>();
  private replayed: Replayed | null = null; // null: what is live is drawn
  private readonly plain = new MeshStandardMaterial({ color: '#b8bfc8', roughness: 0.6, side: DoubleSide });

  // `hidden`: which parts are not drawn, by their vertices; only asked for those that cannot be touched.
  constructor(private readonly hidden: (shape: Shape) => boolean) {}

  setScene(scene: SceneMessage): void {
    if (scene.number !== this.scene?.number) this.clear();
    this.scene = scene;
    this.setReplay(this.replayed);
  }

  // Surfaces of another scene are never drawn on the parts of this one: then nothing is. null: live again. False: that
  // is drawn already.
  setReplay(replayed: Replayed | null): boolean {
    const visible = replayed === null || replayed.scene === this.number;
    let differs = this.group.visible !== visible || (replayed === null) !== (this.replayed === null);
    this.replayed = replayed;
    this.group.visible = visible;
    if (replayed === null) {
      for (const body of this.bodies.values()) body.endReplay();
    } else if (visible) {
      const then = new Map(replayed.surfaces.map((surface) => [surface.object, surface]));
      for (const object of new Set([...this.bodies.keys(), ...then.keys()])) {
        const changes = this.body(object).replay(then.get(object) ?? null, () => this.partsOf(object));
        differs ||= changes;
      }
    }
    return differs;
  }

  get number(): number {
    return this.scene?.number ?? -1;
  }

  // What an object is called: the name of its first part; "": not known.
  name(object: number): string {
    if (!this.group.visible) return '';
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
    body.setParts(this.partsOf(about.object));
    this.showParts(about.object, body);
    return true;
  }

  setSurface(surface: Surface): boolean {
    if (surface.scene !== this.number || !isSurface(surface)) return false;
    this.body(surface.object).set(surface, () => this.partsOf(surface.object));
    return this.replayed === null; // else it is not seen
  }

  // Before drawing.
  update(): void {
    for (const [object, body] of this.bodies) {
      body.update();
      this.showParts(object, body);
    }
  }

  // Again for all: the base is another one.
  hideAgain(): void {
    for (const part of this.parts.values()) if (part.object < 0) part.mesh.visible = !this.hidden(part.shape);
  }

  // Around what can be touched, as it was loaded; empty: nothing can.
  bounds(): Box3 {
    const box = new Box3();
    for (const { object, mesh } of this.parts.values()) {
      if (object < 0) continue;
      if (mesh.geometry.boundingBox === null) mesh.geometry.computeBoundingBox(); // once: vertices stay as loaded
      box.union(mesh.geometry.boundingBox!);
    }
    return box;
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
      body = new Body(this.plain);
      if (this.replayed?.scene === this.number) body.replay(null, () => this.partsOf(object));
      this.bodies.set(object, body);
      this.group.add(body.group);
    }
    return body;
  }

  private partsOf(object: number): Parts {
    const parts = [...this.parts.values()].filter((part) => part.object === object);
    return [parts.map((part) => part.shape), parts.map((part) => part.mesh.material)];
  }

  private showParts(object: number, body: Body): void {
    const visible = body.mesh === null;
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
    for (const body of this.bodies.values()) body.dispose();
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
