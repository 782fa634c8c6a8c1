// The path in space, by three.js. It is loaded when it is first asked for.
import type * as Three from "three";
import { firstAxis } from "./move";
import { RigFigure } from "./rig_figure";
import type { Store } from "./store";

export class SpaceView {
  private three: typeof Three | null = null;
  private renderer!: Three.WebGLRenderer;
  private scene!: Three.Scene;
  private camera!: Three.PerspectiveCamera;
  private content!: Three.Group;
  private ground!: Three.GridHelper;
  private marker!: Three.Mesh;
  private figure: RigFigure | null = null;
  private turn = { azimuth: -0.9, elevation: 0.5, distance: 3.4 };
  axes: [number, number, number] = [0, 1, 2];

  constructor(
    private readonly store: Store,
    private readonly place: HTMLElement,
  ) {
    store.onChange(() => this.draw());
    store.onFrame(() => this.drawFrame());
    new ResizeObserver(() => this.draw()).observe(place);
  }

  async show(): Promise<void> {
    if (!this.three) {
      this.three = await import("three");
      const three = this.three;
      this.renderer = new three.WebGLRenderer({ antialias: true, alpha: true });
      this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
      this.scene = new three.Scene();
      this.camera = new three.PerspectiveCamera(38, 1, 0.01, 100);
      this.camera.up.set(0, 0, 1);
      this.content = new three.Group();
      this.ground = new three.GridHelper(2, 10, 0x4a5160, 0x2b303a);
      this.ground.rotateX(Math.PI / 2);
      this.marker = new three.Mesh(
        new three.SphereGeometry(0.035, 20, 14),
        new three.MeshBasicMaterial({ color: 0xffffff }),
      );
      this.scene.add(this.ground, this.content, this.marker);
      this.place.append(this.renderer.domElement);
      this.listen();
    }
    this.draw();
  }

  private listen(): void {
    const canvas = this.renderer.domElement;
    canvas.tabIndex = 0;
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", "Path in space; the arrows turn it, plus and minus bring it nearer");
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      const turn = (e: PointerEvent): void => this.turnBy(-e.movementX * 0.008, e.movementY * 0.008);
      canvas.addEventListener("pointermove", turn);
      canvas.addEventListener("pointerup", () => canvas.removeEventListener("pointermove", turn), { once: true });
    });
    canvas.addEventListener(
      "wheel",
      (event) => {
        event.preventDefault();
        this.turnBy(0, 0, Math.exp(event.deltaY * 0.001));
      },
      { passive: false },
    );
    canvas.addEventListener("keydown", (event) => {
      const turn = {
        ArrowLeft: [-0.1, 0, 1],
        ArrowRight: [0.1, 0, 1],
        ArrowUp: [0, 0.1, 1],
        ArrowDown: [0, -0.1, 1],
        "+": [0, 0, 0.9],
        "-": [0, 0, 1.1],
      }[event.key];
      if (!turn) return;
      event.preventDefault();
      event.stopPropagation();
      this.turnBy(turn[0], turn[1], turn[2]);
    });
  }

  private turnBy(azimuth: number, elevation: number, nearer = 1): void {
    this.turn.azimuth += azimuth;
    this.turn.elevation = Math.min(Math.max(this.turn.elevation + elevation, -1.5), 1.5);
    this.turn.distance = Math.min(Math.max(this.turn.distance * nearer, 1.5), 12);
    this.render();
  }

  private late = 0;
  /** While something is dragged, every third picture will do: to build it all anew takes long. */
  private isLate(): boolean {
    this.late = this.store.isDragging ? (this.late + 1) % 3 : 0;
    return this.late !== 0;
  }

  private scale: (values: ArrayLike<number>, offset: number) => [number, number, number] = () => [0, 0, 0];

  draw(): void {
    if (!this.three || this.place.hidden || this.place.clientWidth === 0 || this.isLate()) return;
    const three = this.three;
    const { store } = this;
    const track = store.move.tracks[store.selection.track];
    const solved = store.solution.tracks[store.selection.track];
    const axes = track.axes.length;
    const used = this.axes.map((axis) => (axis < axes ? axis : -1));
    // Every axis on its own scale: their units differ more often than not.
    const ranges = used.map((axis) => {
      if (axis < 0) return [0, 1];
      let [low, high] = [Infinity, -Infinity];
      for (let i = axis; i < solved.path.length; i += axes) {
        low = Math.min(low, solved.path[i]);
        high = Math.max(high, solved.path[i]);
      }
      return [low, high];
    });
    this.scale = (values, offset) =>
      used.map((axis, i) => {
        const [low, high] = ranges[i];
        return axis < 0 || high === low ? (i === 2 ? -1 : 0) : (2 * (values[offset + axis] - low)) / (high - low) - 1;
      }) as [number, number, number];
    for (const child of this.content.children as (Three.Line | Three.Mesh)[]) child.geometry.dispose();
    this.content.clear();
    this.figure = store.move.rig?.joints ? new RigFigure(three, store, this.content) : null;
    if (this.figure && !this.figure.build()) this.figure = null;
    this.ground.position.z = this.figure?.ground ?? -1;
    this.place.dataset.shows = this.figure ? "rig" : "axes";
    if (this.figure) return this.drawFrame();
    const points = Array.from(
      { length: solved.path.length / axes },
      (_, i) => new three.Vector3(...this.scale(solved.path, i * axes)),
    );
    this.content.add(
      new three.Line(
        new three.BufferGeometry().setFromPoints(points),
        new three.LineBasicMaterial({ color: 0x6ab0ff }),
      ),
    );
    const ticks: Three.Vector3[] = [];
    for (let f = 0; f < solved.table.length / solved.stride; ++f) {
      const point = new three.Vector3(...this.scale(solved.table, f * solved.stride + 4));
      ticks.push(point, point.clone().add(new three.Vector3(0, 0, 0.05)));
    }
    this.content.add(
      new three.LineSegments(
        new three.BufferGeometry().setFromPoints(ticks),
        new three.LineBasicMaterial({ color: 0x9fb4d0 }),
      ),
    );
    if (!track.path) {
      for (const [k, key] of track.keys.entries()) {
        const color = store.selection.keys.has(k) ? 0xffc14d : 0xe8ecf2;
        const ball = new three.Mesh(new three.SphereGeometry(0.04, 16, 12), new three.MeshBasicMaterial({ color }));
        ball.position.set(...this.scale(key.at, 0));
        this.content.add(ball);
      }
    }
    this.drawFrame();
  }

  private drawFrame(): void {
    if (!this.three || this.place.hidden) return;
    const { store } = this;
    const tip = this.figure?.pose(store.frame);
    if (tip) {
      this.marker.position.copy(tip);
      return this.render();
    }
    const first = firstAxis(store.move, store.selection.track);
    const motion = store.solver.motion(store.frame, 1, 1, store.move.axes.length);
    const here = store.move.tracks[store.selection.track].axes.map((_, a) => motion[(first + a) * 4]);
    this.marker.position.set(...this.scale(here, 0));
    this.render();
  }

  private render(): void {
    const { clientWidth: width, clientHeight: height } = this.place;
    if (width === 0 || height === 0) return;
    const { azimuth, elevation, distance } = this.turn;
    this.camera.aspect = width / height;
    this.camera.position.set(
      distance * Math.cos(elevation) * Math.cos(azimuth),
      distance * Math.cos(elevation) * Math.sin(azimuth),
      distance * Math.sin(elevation),
    );
    this.camera.lookAt(0, 0, this.figure ? 0 : -0.1);
    this.camera.updateProjectionMatrix();
    this.renderer.setSize(width, height, false);
    this.renderer.render(this.scene, this.camera);
  }
}
