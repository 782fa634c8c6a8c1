// The program behind the page: it reads and writes the file, and does what takes a heap or longer.
import { editsOf, type Move } from "./move";

/** A motion as a pointer drew it, position after position; a tolerance of null: the axis does not count. */
export interface DrawnMotion {
  readonly times: readonly number[]; // s
  readonly positions: readonly number[];
  readonly tolerances: readonly (number | null)[];
  readonly weights: readonly number[];
  readonly frames_per_second: number;
}

export interface MotionFit {
  readonly frames: number;
  readonly keys: readonly (readonly number[])[];
  readonly speed: readonly number[];
  readonly deviation: number; // in tolerances
}

/** Of the file as it is now, and which file it is. */
export interface FileState {
  readonly revision: string;
  readonly id: string;
  readonly rig: string | null; // the revision of the rig that counts
  readonly rig_error: string | null; // why its file of today does not
}

/** Something that a file of another program does not say, in the words of `inbetween import`. */
export interface ImportQuestion {
  readonly id: string;
  readonly words: string;
  readonly choices: readonly string[]; // every answer; none: it is written
  readonly suggestion: string; // or ""
  readonly answer: string;
  readonly mistake: string;
  readonly may_stay_open: boolean;
}

export interface WrittenImport {
  readonly move: string;
  readonly rows: string;
  readonly address: string | null;
  readonly why_not: string | null; // there is no address
}

export interface ImportForm {
  readonly questions: readonly ImportQuestion[];
  readonly refused: readonly string[]; // lines
  readonly warnings: readonly string[];
  readonly summary: string | null; // of the move, once it can be made
  readonly written: WrittenImport | null;
}

/** What the program refuses, in its words. */
export class Refusal extends Error {
  constructor(
    readonly status: number,
    message: string,
    readonly revision: string | null,
  ) {
    super(message);
  }
}

export class Server {
  /** Null where the page was opened without a program. */
  static find(): Server | null {
    const token = location.hash.slice(1) || sessionStorage.getItem("inbetween-token");
    if (!token) return null;
    sessionStorage.setItem("inbetween-token", token); // so that loading again keeps it
    history.replaceState(null, "", location.pathname);
    return new Server(token);
  }
  private constructor(private readonly token: string) {}

  open(): Promise<Move> {
    return this.ask("GET", "move") as Promise<Move>;
  }
  /** The move of a text that open() has given before. */
  async document(text: string): Promise<Move> {
    return { ...((await this.ask("POST", "document", { base: text })) as Move), text };
  }
  revision(): Promise<FileState> {
    return this.ask("GET", "revision") as Promise<FileState>;
  }
  async text(move: Move): Promise<string> {
    return ((await this.ask("POST", "text", editsOf(move))) as { text: string }).text;
  }
  resolve(move: Move): Promise<Move> {
    return this.ask("POST", "resolve", editsOf(move)) as Promise<Move>;
  }
  fit(move: Move): Promise<Move> {
    return this.ask("POST", "fit", editsOf(move)) as Promise<Move>;
  }
  fewest(move: Move): Promise<Move> {
    return this.ask("POST", "fewest", editsOf(move)) as Promise<Move>;
  }
  /** `expects` is the revision of the file; `own`: this page has its text. */
  save(move: Move, expects: string, own: boolean): Promise<{ revision: string; kept: string | null }> {
    return this.ask("POST", "save", { ...editsOf(move), expects, own }) as Promise<{
      revision: string;
      kept: string | null;
    }>;
  }
  draw(motion: DrawnMotion): Promise<MotionFit> {
    return this.ask("POST", "draw", motion) as Promise<MotionFit>;
  }
  /** `bytes` in Base64. Nothing is written without `writes`, and with a question open. */
  importMotion(
    { id }: Move,
    file: string,
    bytes: string,
    answers: Record<string, string>,
    writes: boolean,
  ): Promise<ImportForm> {
    return this.ask("POST", "import", { id, file, bytes, answers, writes }) as Promise<ImportForm>;
  }
  /** Null where the file has it. */
  async keep(move: Move): Promise<string | null> {
    return ((await this.ask("POST", "keep", editsOf(move))) as { kept: string | null }).kept;
  }

  private async ask(method: string, what: string, body?: object): Promise<unknown> {
    const headers: Record<string, string> = { "X-Inbetween-Token": this.token };
    if (body) headers["Content-Type"] = "application/json";
    let response: Response;
    let answer: { error?: string; revision?: string };
    try {
      response = await fetch(`/api/${what}`, { method, headers, body: body ? JSON.stringify(body) : undefined });
      answer = (await response.json()) as typeof answer; // which may be cut off
    } catch {
      throw new Refusal(0, "the program has ended", null);
    }
    if (!response.ok)
      throw new Refusal(response.status, answer.error ?? "The program refused.", answer.revision ?? null);
    return answer;
  }
}
