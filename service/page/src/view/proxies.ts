// Contacts: where the proxy is on the surface, the line from the tip to it, and the direction of the surface as a disc.
import {
  CircleGeometry, DoubleSide, Group, Mesh, MeshBasicMaterial, RingGeometry, SphereGeometry, Vector3, type Vector2,
} from 'three';
import type { Contact, Vec3 } from '../types';
import type { Palette } from './palette';
import { Ribbon } from './ribbon';
import { Mark } from './forces';

const kMost = 4; // contacts in a Live message
const kDisc = 0.005; // m
const kLift = 1.5e-4; // m of the disc over the surface

class Proxy {
  readonly group = new Group();
  private readonly ball = new Mark(new SphereGeometry(0.00085, 20, 14), 1, 0.9);
  private readonly disc = new Group();
  private readonly fill = new MeshBasicMaterial({
    side: DoubleSide, transparent: true, opacity: 0.28, depthWrite: false, toneMapped: false,
  });
  private readonly rim = new Mark(new RingGeometry(kDisc * 0.9, kDisc, 48), 0.95, 0.4);
  private readonly plate: Mesh;
  private readonly link: Ribbon;
  private readonly ends = new Float32Array(6);

  constructor(resolution: { value: Vector2 }) {
    this.link = new Ribbon(2, 2, resolution);
    this.link.material.depthTest = false; // it lies below the surface
    this.link.renderOrder = 7;
    this.rim.mesh.material.side = DoubleSide;
    this.plate = new Mesh(new CircleGeometry(kDisc * 0.9, 48), this.fill);
    this.plate.renderOrder = 5;
    this.disc.add(this.plate, this.rim.mesh);
    this.group.add(this.ball.mesh, this.disc, this.link);
  }

  place(contact: Contact, tip: Vec3): void {
    const normal = new Vector3(...contact.normal);
    if (!(normal.lengthSq() > 1e-9)) normal.set(0, 0, 1);
    normal.normalize();
    this.ball.mesh.position.set(...contact.point);
    this.disc.position.set(...contact.point).addScaledVector(normal, kLift);
    this.disc.quaternion.setFromUnitVectors(new Vector3(0, 0, 1), normal);
    this.ends.set([...tip, ...contact.point]);
    this.link.setPoints(this.ends, new Float32Array([1, 1]), 2);
  }

  setPalette(palette: Palette): void {
    this.ball.setColour(palette.proxy, 0.45);
    this.rim.setColour(palette.proxy, 0.45);
    this.fill.color.copy(palette.proxy);
    this.link.setColour(palette.proxy);
  }
}

export class Proxies {
  readonly group = new Group();
  private readonly proxies: Proxy[];

  constructor(resolution: { value: Vector2 }) {
    this.proxies = Array.from({ length: kMost }, () => new Proxy(resolution));
    for (const proxy of this.proxies) this.group.add(proxy.group);
  }

  place(contacts: Contact[], tip: Vec3): void {
    this.proxies.forEach((proxy, i) => {
      const contact = contacts[i];
      proxy.group.visible = contact !== undefined;
      if (contact !== undefined) proxy.place(contact, tip);
    });
  }

  setPalette(palette: Palette): void {
    for (const proxy of this.proxies) proxy.setPalette(palette);
  }
}
