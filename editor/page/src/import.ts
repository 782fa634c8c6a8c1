// A file of another program that is dropped on the page: the program asks what `inbetween import` asks, and this is the
// form around it. What a question means, and what answers it, the program knows.
import type { Bar } from "./bar";
import { attributes, button, html, say } from "./dom";
import type { ImportForm, ImportQuestion, Server, WrittenImport } from "./server";
import type { Store } from "./store";

const max_bytes = 16 * 2 ** 20; // in Base64, what a request may have

function base64Of(file: File): Promise<string> {
  return new Promise((resolve, reject) => {
    const reader = new FileReader();
    reader.onload = () => resolve((reader.result as string).replace(/^[^,]*,/, ""));
    reader.onerror = () => reject(new Error(`${file.name} cannot be read`));
    reader.readAsDataURL(file);
  });
}

/** What a choice is called where its word alone tells too little. */
function labelOf({ id }: ImportQuestion, choice: string): string {
  if (!id.startsWith("axis ")) return choice;
  if (choice === "-") return "none: leave it out";
  return choice.startsWith("-") ? `${choice.slice(1)}, the other way` : choice;
}

/** A question and its field; `change` takes what somebody chose or wrote. */
class Row {
  readonly field: HTMLInputElement | HTMLSelectElement;
  readonly element: HTMLElement;
  private readonly note = html("small");
  private readonly mistake = html("small", { class: "bad", role: "alert" });
  private isTyped = false; // and not yet taken

  constructor(
    readonly question: ImportQuestion,
    change: (answer: string) => void,
  ) {
    const { id, choices, words, may_stay_open } = question;
    const name = `import-${id.replaceAll(" ", "-")}`;
    this.field =
      choices.length === 0
        ? html("input", { id: name, autocomplete: "off", spellcheck: "false" })
        : html(
            "select",
            { id: name },
            html("option", { value: "" }, may_stay_open ? "as usual" : "choose"),
            ...choices.map((choice) => html("option", { value: choice }, labelOf(question, choice))),
          );
    attributes(this.field, { "aria-describedby": `${name}-note` });
    this.note.id = `${name}-note`;
    this.field.addEventListener("input", () => (this.isTyped = true));
    this.field.addEventListener("change", () => {
      this.isTyped = false;
      change(this.field.value);
    });
    this.element = html(
      "div",
      { class: "question" },
      html("label", { for: name }, words),
      html("span", {}, this.field, " ", this.note),
      this.mistake,
    );
  }

  draw(answer: string, isSuggested: boolean, mistake: string): void {
    if (!this.isTyped) this.field.value = answer;
    this.field.classList.toggle("suggested", isSuggested);
    this.note.textContent = isSuggested ? "suggested" : "";
    this.mistake.textContent = mistake;
  }
}

const lines = (what: string, texts: readonly string[]): HTMLElement =>
  html("div", { class: `lines ${what}`, role: what === "refused" ? "alert" : "note" }, texts.join("\n"));

/** One file on its way. */
class Import {
  private readonly dialog = html("dialog", { id: "import", "aria-labelledby": "import-title" });
  private readonly told = html("div");
  private readonly questions = html("div", { class: "questions" });
  private readonly make = button(
    "Make the move",
    "Write the move and its rows beside the move that is open",
    () => this.ask(true),
    "import-make",
  );
  private readonly said = new Map<string, string>(); // answers
  private suggested = new Map<string, string>(); // which nobody has agreed to
  private rows = new Map<string, Row>();
  private last: Promise<void> = Promise.resolve(); // of what is asked one after the other

  constructor(
    private readonly store: Store,
    private readonly server: Server,
    private readonly bar: Bar,
    private readonly file: string,
    private readonly bytes: string,
  ) {
    this.dialog.addEventListener("keydown", (event) => event.stopPropagation()); // the keys of the page are not for it
    this.dialog.addEventListener("close", () => this.dialog.remove());
    this.dialog.append(
      html("h2", { id: "import-title" }, `Import ${file}`),
      html("p", {}, "What the file does not say is asked, and never guessed."),
      this.questions,
      this.told,
      html("div", { class: "tools" }, this.make, this.closing("Cancel", "Nothing is written")),
    );
  }
  private closing(label: string, title: string): HTMLButtonElement {
    return button(label, title, () => this.dialog.close(), "import-close");
  }

  /** Throws the program's refusal where there is nothing to ask. */
  async begin(): Promise<void> {
    const form = await this.look(false);
    document.body.append(this.dialog);
    this.draw(form);
    this.dialog.showModal();
  }

  /** What is suggested is looked at as if it were the answer, so that all questions can be seen at once. */
  private async look(writes: boolean): Promise<ImportForm> {
    const suggested = new Map<string, string>();
    for (;;) {
      const answers = Object.fromEntries([...suggested, ...this.said]);
      const form = await this.server.importMotion(this.store.move, this.file, this.bytes, answers, writes);
      const more = form.questions.filter(({ id, suggestion }) => suggestion !== "" && !(id in answers));
      if (more.length === 0 || form.written) {
        this.suggested = suggested;
        return form;
      }
      for (const { id, suggestion } of more) suggested.set(id, suggestion);
    }
  }

  private ask(writes: boolean): void {
    const seen = this.suggestions();
    this.last = this.last.then(() => this.askNow(writes, seen));
  }
  private suggestions(): string {
    return JSON.stringify([...this.suggested]);
  }
  private async askNow(writes: boolean, seen: string): Promise<void> {
    this.make.setAttribute("aria-busy", "true");
    try {
      // Who presses it agrees to what is there; where that has changed since, to nothing.
      const agrees = writes && seen === this.suggestions();
      if (agrees) for (const [id, answer] of this.suggested) this.said.set(id, answer);
      else if (writes) say("What is suggested has changed: look again.");
      const form = await this.look(agrees);
      if (form.written) return this.tellWritten(form, form.written);
      this.draw(form);
      const open = form.questions.find(({ answer, mistake, may_stay_open }) => mistake || !(answer || may_stay_open));
      if (writes && open) this.rows.get(open.id)?.field.focus();
    } catch (error) {
      this.told.replaceChildren(lines("refused", [(error as Error).message]));
    } finally {
      this.make.removeAttribute("aria-busy");
    }
  }

  private draw({ questions, refused, warnings, summary }: ImportForm): void {
    const shape = ({ words, choices }: ImportQuestion): string => JSON.stringify([words, choices]);
    const before = [...this.rows.values()];
    const focused = document.activeElement as HTMLElement | null;
    this.rows = new Map(
      questions.map((question) => {
        const there = this.rows.get(question.id);
        const isSame = there && shape(there.question) === shape(question);
        return [question.id, isSame ? there : new Row(question, (answer) => this.take(question.id, answer))];
      }),
    );
    const rows = [...this.rows.values()];
    if (rows.length !== before.length || rows.some((row, i) => row !== before[i])) {
      this.questions.replaceChildren(...rows.map(({ element }) => element));
      if (this.dialog.contains(focused)) focused?.focus();
    }
    for (const { id, mistake } of questions)
      this.rows
        .get(id)!
        .draw(this.said.get(id) ?? this.suggested.get(id) ?? "", !this.said.has(id) && this.suggested.has(id), mistake);
    this.told.replaceChildren(
      ...(refused.length > 0
        ? [lines("refused", refused), html("p", {}, "Change an answer, or correct the file and drop it again.")]
        : []),
      ...(warnings.length > 0 ? [lines("warnings", warnings)] : []),
      ...(summary ? [html("p", {}, `The move: ${summary}.`)] : []),
    );
    const agreed = questions.filter(({ id }) => this.suggested.has(id)).length;
    this.make.disabled = refused.length > 0;
    this.make.textContent =
      agreed > 0
        ? `Agree to ${agreed === 1 ? "what is suggested" : `${agreed} suggestions`}, make the move`
        : "Make the move";
  }
  private take(id: string, answer: string): void {
    this.said.set(id, answer);
    this.ask(false);
  }

  private tellWritten(form: ImportForm, { move, rows, address, why_not }: WrittenImport): void {
    const { file } = this.store.move;
    const go = (): void => location.assign(address!);
    const saveAndGo = async (): Promise<void> => {
      await this.bar.save();
      if (!this.store.isChanged) return go();
      this.dialog.close();
      say(`${file} is not saved, and ${move} is not opened.`, true);
    };
    const isChanged = this.store.isChanged;
    const opening = isChanged
      ? [
          button(
            `Save ${file}, open ${move}`,
            "Save what you edited, then go on",
            () => void saveAndGo(),
            "import-save",
          ),
          button(`Open ${move}`, "Go on; this browser keeps what you edited", go, "import-open"),
        ]
      : [button(`Open ${move}`, "Go to the page of the new move", go, "import-open")];
    this.dialog.replaceChildren(
      html("h2", { id: "import-title" }, `${move} is written`),
      html("p", {}, `${form.summary}. Its rows are in ${rows}, beside ${file}.`),
      ...(form.warnings.length > 0 ? [lines("warnings", form.warnings)] : []),
      ...(why_not ? [lines("refused", [`It cannot be opened here: ${why_not}`])] : []),
      ...(address && isChanged ? [html("p", {}, `What you edited in ${file} is not saved.`)] : []),
      html("p", {}, `It can be opened at any time with: inbetween edit ${move} --rig RIG`),
      html("div", { class: "tools" }, ...(address ? opening : []), this.closing("Stay here", `Go on with ${file}`)),
    );
    this.dialog.querySelector("button")?.focus();
  }
}

/** Takes what is dropped on the page, and gives the button for those who do not drag. */
export function importing(store: Store, server: Server, bar: Bar): HTMLElement[] {
  const take = async (files: readonly File[]): Promise<void> => {
    if (document.querySelector("dialog[open]")) return say("Answer what is asked first.", true);
    if (files.length !== 1) return say("Drop one file at a time.", true);
    const [file] = files;
    if (file.name.endsWith(".toml")) return say(`A move is opened with: inbetween edit ${file.name}`, true);
    if (file.size > max_bytes)
      return say(`${file.name} has more than ${max_bytes / 2 ** 20} MiB; take inbetween import for it.`, true);
    try {
      await new Import(store, server, bar, file.name, await base64Of(file)).begin();
    } catch (error) {
      say(`Not imported: ${(error as Error).message}.`, true);
    }
  };
  const input = html("input", { type: "file", id: "import-file", hidden: true, "aria-label": "A file to import" });
  input.addEventListener("change", () => {
    const files = [...(input.files ?? [])];
    input.value = ""; // the same file once more is a change too
    void take(files);
  });
  document.addEventListener("dragover", (event) => event.preventDefault());
  document.addEventListener("drop", (event) => {
    event.preventDefault();
    void take([...(event.dataTransfer?.files ?? [])]);
  });
  const title = "Make a move of a file of another program (or drop it on the page)";
  return [input, button("Import…", title, () => input.click(), "import-button")];
}
