// What the page shows: the move, its solution, what is selected, and where the preview is. Everything that changes the
// move goes through here, so that there is one history.
import { type Move } from "./move";
import { isError, type Solution, Solver, type SolverError } from "./solver";

export interface Selection {
  readonly track: number;
  readonly keys: ReadonlySet<number>;
  readonly values: ReadonlySet<number>; // control values
}

const none: ReadonlySet<number> = new Set();

export class Store {
  move: Move;
  solution: Solution;
  error: SolverError | null = null; // the solution is that of the last move that could be solved
  selection: Selection = { track: 0, keys: none, values: none };
  frame = 0;
  solveMs = 0;
  private undone: Move[] = [];
  private done: Move[] = [];
  private gesture: Move | null = null;
  private pending = false;
  private readonly listeners: (() => void)[] = [];
  private readonly frameListeners: (() => void)[] = [];
  onCommit: () => void = () => {};

  constructor(readonly solver: Solver, move: Move) {
    this.move = move;
    this.good = move;
    const first = solver.solve(move);
    if (isError(first)) throw new Error(`${first.what}; ${first.remedy}`);
    this.solution = first;
  }

  onChange(listener: () => void): void {
    this.listeners.push(listener);
  }
  onFrame(listener: () => void): void {
    this.frameListeners.push(listener);
  }

  /** One edit, one step of undo. */
  edit(move: Move): void {
    if (move === this.move) return;
    if (this.gesture === null) this.done.push(this.move);
    this.undone = [];
    this.show(move);
    if (this.gesture === null) this.onCommit();
  }
  /** What follows until end() is one step of undo: a drag. */
  begin(): void {
    this.gesture = this.move;
  }
  end(): void {
    const before = this.gesture;
    this.gesture = null;
    if (before === null || before === this.move) return;
    this.done.push(before);
    this.solveSoon(); // what was left out while it was dragged
    this.onCommit();
  }
  get isDragging(): boolean {
    return this.gesture !== null;
  }
  cancel(): void {
    const before = this.gesture;
    this.gesture = null;
    if (before) this.show(before);
  }
  get canUndo(): boolean {
    return this.done.length > 0;
  }
  get canRedo(): boolean {
    return this.undone.length > 0;
  }
  undo(): void {
    const before = this.done.pop();
    if (!before) return;
    this.undone.push(this.move);
    this.show(before);
    this.onCommit();
  }
  redo(): void {
    const after = this.undone.pop();
    if (!after) return;
    this.done.push(this.move);
    this.show(after);
    this.onCommit();
  }
  /** The same move by other words, such as its new revision: no step of undo. */
  amend(change: (move: Move) => Move): void {
    this.move = change(this.move);
    this.done = this.done.map(change);
    this.undone = this.undone.map(change);
    this.solveSoon();
  }
  /** Another file content: undo begins anew. */
  replace(move: Move): void {
    this.done = [];
    this.undone = [];
    this.select({ track: 0, keys: none, values: none });
    this.show(move);
  }

  select(selection: Partial<Selection>): void {
    this.selection = { ...this.selection, ...selection };
    this.solveSoon();
  }
  selectKey(key: number, more = false): void {
    this.select({ keys: toggled(this.selection.keys, key, more), values: none });
  }
  selectValue(value: number, more = false): void {
    this.select({ values: toggled(this.selection.values, value, more), keys: none });
  }

  setFrame(frame: number): void {
    this.frame = frame;
    for (const listener of this.frameListeners) listener();
  }

  private show(move: Move): void {
    this.move = move;
    this.solveSoon();
  }
  /** At most once a picture: several pointer events may come before it is drawn. */
  private solveSoon(): void {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame(() => {
      this.pending = false;
      this.solveNow();
    });
  }
  private solved: Move | null = null;
  private good: Move;
  private solveNow(): void {
    const begin = performance.now();
    if (this.solved !== this.move) {
      const result = this.solver.solve(this.move);
      this.error = isError(result) ? result : null;
      if (isError(result)) {
        this.solver.solve(this.good); // what is shown goes on being what was solved last
      } else {
        this.solution = result;
        this.good = this.move;
      }
      this.solved = this.move;
    }
    const { track, keys, values } = this.selection;
    const one = this.move.tracks[track];
    const within = (set: ReadonlySet<number>, size: number): ReadonlySet<number> =>
      [...set].every((i) => i < size) ? set : new Set([...set].filter((i) => i < size));
    this.selection = { track, keys: within(keys, one.keys.length), values: within(values, one.speed?.length ?? 0) };
    this.frame = Math.min(Math.max(this.frame, this.solution.firstFrame), this.solution.lastFrame);
    this.solveMs = performance.now() - begin;
    for (const listener of this.listeners) listener();
  }
}

function toggled(set: ReadonlySet<number>, item: number, more: boolean): ReadonlySet<number> {
  if (!more) return new Set([item]);
  const result = new Set(set);
  if (!result.delete(item)) result.add(item);
  return result;
}
