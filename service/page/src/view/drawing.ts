// Everything that is drawn, from a Picture. Exists only where there is WebGL 2.
import type { PerspectiveCamera } from 'three';
import type { Hello, Shape } from '../types';
import { BaseStation, liesInHull } from './base_station';
import { Car } from './car';
import { ForceArrow, Spring } from './forces';
import type { Palette } from './palette';
import { Ghost, Pen } from './pen';
import type { Picture } from './picture';
import { Proxies } from './proxies';
import type { SceneParts } from './scene_parts';
import { Stage } from './stage';
import { Trail } from './trail';
import { Uncertainty } from './uncertainty';

interface Device {
  base: BaseStation;
  pen: Pen;
  ghost: Ghost;
}

export class Drawing {
  readonly stage: Stage;
  readonly trail: Trail;
  private readonly arrow = new ForceArrow();
  private readonly proxies: Proxies;
  private readonly uncertainty = new Uncertainty();
  private readonly spring: Spring;
  private readonly car = new Car();
  private device: Device | null = null;
  private palette: Palette | null = null;
  visitor = false; // is shown no uncertainty

  constructor(canvas: HTMLCanvasElement, private readonly parts: SceneParts) {
    this.stage = new Stage(canvas);
    this.trail = new Trail(this.stage.resolution);
    this.proxies = new Proxies(this.stage.resolution);
    this.spring = new Spring(this.stage.resolution);
    this.stage.scene.add(
      parts.group, this.car.group, this.trail.line, this.uncertainty.mesh, this.arrow.group, this.proxies.group,
      this.spring.group,
    );
  }

  setBase(base: Hello['base']): void {
    if (this.device !== null) {
      for (const old of [this.device.base, this.device.pen, this.device.ghost]) {
        old.group.removeFromParent();
        old.dispose();
      }
    }
    this.device = { base: new BaseStation(base), pen: new Pen(base.magnet), ghost: new Ghost(base.magnet) };
    for (const { group } of Object.values(this.device)) this.stage.scene.add(group);
    this.stage.desk.place(this.device.base.deskHeight, this.device.base.footRadius);
    if (this.palette !== null) this.setPalette(this.palette);
  }

  setPalette(palette: Palette): void {
    this.palette = palette;
    const { stage, trail, arrow, proxies, uncertainty, spring, car, device } = this;
    for (const drawn of [stage, trail, arrow, proxies, uncertainty, spring, car]) drawn.setPalette(palette);
    if (device !== null) for (const drawn of [device.base, device.pen, device.ghost]) drawn.setPalette(palette);
  }

  place(picture: Picture): void {
    const { tip, aim, valid, tracked } = picture;
    if (this.device !== null) {
      const { base, pen, ghost } = this.device;
      base.setCurrents(picture.currents);
      pen.group.visible = valid;
      if (valid) pen.place(tip, picture.orientation, tracked);
      if (aim.present) ghost.place(aim.tip, aim.axis, valid ? tip : null);
      else ghost.group.visible = false;
    }
    if (valid && aim.present) this.spring.place(aim.tip, tip);
    else this.spring.group.visible = false;
    if (valid && tracked) {
      this.arrow.place(tip, picture.force);
      if (this.visitor) this.uncertainty.mesh.visible = false;
      else this.uncertainty.place(tip, picture.covariance);
    } else {
      this.arrow.group.visible = false;
      this.uncertainty.mesh.visible = false;
    }
    this.proxies.place(valid && tracked ? picture.contacts : [], tip);
    this.car.place(picture.vehicle);
  }

  draw(camera: PerspectiveCamera): void {
    this.parts.update();
    this.stage.render(camera);
  }
}

// What of a scene is not drawn: parts that only show the base's own hull, which is drawn anyway, with what is in it.
export function repeatsHull(shape: Shape, hello: Hello | null): boolean {
  return hello !== null && liesInHull(shape.positions, hello.base);
}
