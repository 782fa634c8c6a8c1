// The rig in space: a rod from every joint to the next, as the core poses them, and the path of its tip.
import type * as Three from "three";
import type { Store } from "./store";

export class RigFigure {
  private readonly rods: { mesh: Three.Mesh; from: number; to: number }[] = [];
  private readonly knuckles: Three.Mesh[] = [];
  /** How high the lowest place is, in the units of the scene. */
  ground = -1;
  private scale: (places: Float64Array, link: number) => Three.Vector3 = () => new this.three.Vector3();
  private readonly links: number;
  private readonly tip: number;

  constructor(
    private readonly three: typeof Three,
    private readonly store: Store,
    private readonly content: Three.Group,
  ) {
    const joints = store.move.rig!.joints!;
    this.links = joints.length;
    this.tip = store.move.rig!.tip ?? joints.length - 1;
  }

  private places(first: number, step: number, samples: number): Float64Array | null {
    const { move, solver } = this.store;
    return solver.places(move.rig!, move.axes.length, first, step, samples);
  }

  /** Anew for another motion: the box in which the rig moves, the path of the tip with a dot for every frame, the rods. */
  build(): boolean {
    const { three, store, content, links } = this;
    const { firstFrame, lastFrame } = store.solution;
    const samples = Math.min(Math.round(lastFrame - firstFrame) + 1, 1000);
    const all = this.places(firstFrame, (lastFrame - firstFrame) / Math.max(samples - 1, 1), samples);
    if (!all) return false;
    const low = [Infinity, Infinity, Infinity];
    const high = [-Infinity, -Infinity, -Infinity];
    for (let i = 0; i < all.length; ++i) {
      low[i % 3] = Math.min(low[i % 3], all[i]);
      high[i % 3] = Math.max(high[i % 3], all[i]);
    }
    const size = Math.max(...high.map((top, i) => top - low[i]), 1e-6);
    // One scale for all: metres are metres.
    this.ground = (low[2] - high[2]) / size;
    this.scale = (places, link) =>
      new three.Vector3(
        (places[3 * link] - (low[0] + high[0]) / 2) * (2 / size),
        (places[3 * link + 1] - (low[1] + high[1]) / 2) * (2 / size),
        (places[3 * link + 2] - (low[2] + high[2]) / 2) * (2 / size),
      );
    const path = Array.from({ length: samples }, (_, i) => this.scale(all, i * links + this.tip));
    const line = new three.BufferGeometry().setFromPoints(path);
    content.add(
      new three.Line(line, new three.LineBasicMaterial({ color: 0x6ab0ff })),
      new three.Points(line, new three.PointsMaterial({ color: 0x9fb4d0, size: 2, sizeAttenuation: false })),
    );
    const metal = new three.MeshBasicMaterial({ color: 0xc9d2df });
    this.rods.length = 0;
    store.move.rig!.joints!.forEach(({ parent }, to) => {
      if (parent < 0) return;
      const mesh = new three.Mesh(new three.CylinderGeometry(0.014, 0.02, 1, 10), metal);
      this.rods.push({ mesh, from: parent, to });
      content.add(mesh);
    });
    const knuckle = new three.SphereGeometry(0.024, 12, 10);
    this.knuckles.length = 0;
    for (let link = 0; link < links; ++link) {
      this.knuckles.push(
        new three.Mesh(knuckle, new three.MeshBasicMaterial({ color: link === this.tip ? 0xffc14d : 0xe8ecf2 })),
      );
    }
    content.add(...this.knuckles);
    return true;
  }

  /** Where the tip is at that frame. */
  pose(frame: number): Three.Vector3 | null {
    const places = this.places(frame, 0, 1);
    if (!places) return null;
    const up = new this.three.Vector3(0, 1, 0);
    for (const { mesh, from, to } of this.rods) {
      const a = this.scale(places, from);
      const b = this.scale(places, to);
      const length = a.distanceTo(b);
      mesh.visible = length > 1e-4;
      mesh.position.copy(a).lerp(b, 0.5);
      mesh.scale.set(1, Math.max(length, 1e-4), 1);
      mesh.quaternion.setFromUnitVectors(up, b.sub(a).normalize());
    }
    this.knuckles.forEach((ball, link) => ball.position.copy(this.scale(places, link)));
    return this.scale(places, this.tip);
  }
}
