// Which commands a typed text means, the likeliest first. Pure.

import { COMMANDS, type PageCommand } from "../actions/commands";
import { SYNONYMS } from "../actions/synonyms";

/** How well a text fits a command; smaller is better. */
const FIT = {
  /** It is the title, or the label. */
  whole: 0,
  /** The title begins with it. */
  beginning: 1,
  /** It is another word for the command. */
  synonym: 2,
  /** Each of its words begins a word of the title. */
  words: 3,
  /** Each of its words begins a word of the title, the group or a synonym. */
  any_words: 4,
  /** Each of its words is somewhere in them. */
  within: 5,
  /** Its letters occur in the title, in order. */
  letters: 6,
} as const;

/** Fewer letters in order are in every other title. */
const LEAST_LETTERS = 2;

interface Ranked {
  readonly command: PageCommand;
  readonly fit: number;
  /** The length of the title: the shorter says less besides. */
  readonly length: number;
}

/**
 * The commands that a typed text may mean, the likeliest first; without a text all of them, as in the table.
 *
 * labelOf: what a command is called at present, which counts like its title.
 */
export function matchingCommands(
  query: string,
  commands: readonly PageCommand[] = COMMANDS,
  labelOf: (command: PageCommand) => string = (command) => command.title,
): PageCommand[] {
  const known = commands.filter((command) => command.while !== "typing");
  const wanted = plain(query);
  if (wanted === "") return [...known];
  const ranked = known.flatMap((command): Ranked[] => {
    const names = [...new Set([plain(labelOf(command)), plain(command.title)])];
    const fit = fitOf(wanted, names, plain(command.group), (SYNONYMS[command.id] ?? []).map(plain));
    return fit === null ? [] : [{ command, fit, length: (names[0] ?? "").length }];
  });
  // The sort is stable: equal ones stay in the order of the table.
  return ranked.sort((a, b) => a.fit - b.fit || a.length - b.length).map(({ command }) => command);
}

function fitOf(wanted: string, names: readonly string[], group: string, synonyms: readonly string[]): number | null {
  if (names.includes(wanted)) return FIT.whole;
  if (names.some((name) => name.startsWith(wanted))) return FIT.beginning;
  if (synonyms.includes(wanted)) return FIT.synonym;
  const words = wanted.split(" ");
  if (names.some((name) => words.every((word) => beginsAWord(name, word)))) return FIT.words;
  const all = [...names, group, ...synonyms];
  if (words.every((word) => all.some((text) => beginsAWord(text, word)))) return FIT.any_words;
  if (words.every((word) => all.some((text) => text.includes(word)))) return FIT.within;
  const letters = wanted.replaceAll(" ", "");
  if (letters.length >= LEAST_LETTERS && names.some((name) => hasInOrder(name, letters))) return FIT.letters;
  return null;
}

const beginsAWord = (text: string, word: string): boolean => text.startsWith(word) || text.includes(` ${word}`);

function hasInOrder(text: string, letters: string): boolean {
  let from = 0;
  for (const letter of letters) {
    from = text.indexOf(letter, from) + 1;
    if (from === 0) return false;
  }
  return true;
}

/** Without capitals and signs: "Contact: pass" is "contact pass". */
const plain = (text: string): string =>
  text
    .toLowerCase()
    .replace(/[^\p{L}\p{N}"]+/gu, " ")
    .trim();
