// Asks the user for files of their machine.

/** Asks for a file, by suffixes and types as `accept` has them; the function gets it. */
export const chooseFile = (accept: string, taken: (file: File) => unknown): void =>
  choose(accept, false, ([file]) => {
    if (file) taken(file);
  });

/** Asks for several files. */
export const chooseSeveral = (accept: string, taken: (files: readonly File[]) => unknown): void =>
  choose(accept, true, taken);

let asked: HTMLInputElement | null = null;

function choose(accept: string, multiple: boolean, taken: (files: readonly File[]) => unknown): void {
  asked?.remove(); // a browser that does not tell that nothing was chosen
  const input = document.createElement("input");
  Object.assign(input, { type: "file", accept, multiple, hidden: true });
  input.addEventListener("change", () => {
    input.remove();
    taken([...(input.files ?? [])]);
  });
  input.addEventListener("cancel", () => input.remove());
  // In the page, because one that nothing holds may be gone before its files are chosen.
  document.body.append(input);
  asked = input;
  input.click();
}
