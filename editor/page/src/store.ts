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
  /** The history: those before `at` can be undone to, those behind it done again. */
  states: readonly Move[];
  at = 0;
  saved: Move | null; // what the file has, as far as this page knows
  sent: Move | null = null; // the last one that was sent to be saved
  private gesture: Move | null = null;
  private pending = false;
  private readonly listeners: (() => void)[] = [];
  private readonly frameListeners: (() => void)[] = [];
  onCommit: () => void = () => {};

  constructor(
    readonly solver: Solver,
    move: Move,
  ) {
    this.move = move;
    this.states = [move];
    this.saved = move;
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
    if (this.gesture !== null) return this.show(move);
    // A file that was loaded and undone may be nowhere else: it stays, and undo goes back to it.
    const { revision } = this.states[this.at];
    const isNeeded = this.states.slice(this.at + 1).some((undone) => undone.revision !== revision);
    this.states = isNeeded ? this.behindAll(move) : [...this.states.slice(0, this.at + 1), move];
    this.go(this.states.length - 1);
  }
  /** What follows until end() is one step of undo: a drag. */
  begin(): void {
    this.gesture = this.move;
  }
  end(): void {
    const before = this.gesture;
    const after = this.move;
    this.gesture = null;
    this.move = before ?? after;
    this.edit(after);
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
    return this.at > 0;
  }
  get canRedo(): boolean {
    return this.at < this.states.length - 1;
  }
  undo(): void {
    if (this.canUndo && !this.isDragging) this.go(this.at - 1);
  }
  redo(): void {
    if (this.canRedo && !this.isDragging) this.go(this.at + 1);
  }
  /** The same move by other words: no step of undo. */
  amend(change: (move: Move) => Move): void {
    const changed = new Map<Move, Move>(); // what is saved stays what is shown
    const once = (move: Move): Move => {
      const result = changed.get(move) ?? change(move);
      changed.set(move, result);
      return result;
    };
    this.saved = this.saved && once(this.saved);
    this.sent = this.sent && once(this.sent);
    this.states = this.states.map(once);
    this.move = once(this.move);
    this.solveSoon();
  }
  /** What the file has now: a step of undo like every other, so that what was here before stays; what could be done again
   * stays before it too. */
  load(move: Move): void {
    this.gesture = null;
    this.states = this.behindAll(move);
    this.saved = move;
    this.select({ track: 0, keys: none, values: none });
    this.go(this.states.length - 1);
  }
  /** A history that was kept in the place of this one. */
  restore(states: readonly Move[], at: number, saved: Move | null): void {
    this.states = states;
    this.saved = saved;
    this.at = at;
    this.show(states[at]);
  }
  /** Why this page cannot show a move, or null. */
  refusalOf(move: Move): string | null {
    const result = this.solver.solve(move);
    this.solver.solve(this.good);
    return isError(result) ? `${result.what}; ${result.remedy}` : null;
  }
  get isChanged(): boolean {
    return this.move !== this.saved;
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

  /** The history with a step more, behind what could be done again and the state that is shown. */
  private behindAll(move: Move): readonly Move[] {
    return [...this.states, ...(this.canRedo ? [this.states[this.at]] : []), move];
  }
  private go(at: number): void {
    this.at = at;
    this.show(this.states[at]);
    this.onCommit();
  }
  private show(move: Move): void {
    this.move = move;
    // Another version of the file may have fewer tracks.
    if (this.selection.track >= move.tracks.length) this.selection = { track: 0, keys: none, values: none };
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
