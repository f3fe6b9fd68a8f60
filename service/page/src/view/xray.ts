// Marks must be seen even where something hides them: their hidden part is drawn once more, translucent.
import { BufferGeometry, Color, GreaterDepth, Mesh, MeshBasicMaterial, MeshStandardMaterial } from 'three';

export class Mark {
  readonly mesh: Mesh<BufferGeometry, MeshStandardMaterial>;
  private readonly hidden: MeshBasicMaterial;

  constructor(geometry: BufferGeometry, opacity = 1, hiddenOpacity = 0.5) {
    const material = new MeshStandardMaterial({ roughness: 0.55, transparent: opacity < 1, opacity });
    material.depthWrite = opacity === 1;
    this.hidden = new MeshBasicMaterial({ transparent: true, opacity: hiddenOpacity * opacity, toneMapped: false });
    this.hidden.depthFunc = GreaterDepth;
    this.hidden.depthWrite = false;
    this.mesh = new Mesh(geometry, material);
    const behind = new Mesh(geometry, this.hidden);
    behind.renderOrder = 6;
    this.mesh.renderOrder = opacity < 1 ? 5 : 0;
    this.mesh.add(behind);
  }

  setColour(colour: Color, glow = 0.35): void {
    this.mesh.material.color.copy(colour);
    this.mesh.material.emissive.copy(colour).multiplyScalar(glow);
    this.hidden.color.copy(colour);
  }
}
