// The parts as a tree: their paths, cut at the slashes. Plain data; the component draws the visible rows.

export interface PartNode {
  readonly name: string;
  readonly path: string;
  readonly parent: number;
  readonly depth: number;
  /** The part's id; -1 for a group. */
  readonly part: number;
  readonly children: number[];
}

/** One visible line. */
export interface TreeRow {
  readonly node: number;
  readonly depth: number;
  readonly isGroup: boolean;
  readonly isOpen: boolean;
  /** Its place among its siblings that can be seen, from 1, and how many they are. */
  readonly place: number;
  readonly siblings: number;
}

export class PartTree {
  readonly nodes: PartNode[] = [];
  readonly roots: number[] = [];
  private readonly searched: string[] = [];
  private readonly node_of_part: Int32Array;

  /** `absent`: parts that have no line. */
  constructor(paths: readonly string[], absent: ReadonlySet<number> = new Set()) {
    this.node_of_part = new Int32Array(paths.length).fill(-1);
    const groups = new Map<string, number>();
    for (const [part, path] of paths.entries()) {
      if (absent.has(part)) continue;
      const names = path.split("/").filter((name) => name !== "");
      if (names.length === 0) names.push(`part ${part}`);
      let parent = -1;
      let prefix = "";
      for (const name of names.slice(0, -1)) {
        prefix = prefix === "" ? name : `${prefix}/${name}`;
        const known = groups.get(prefix);
        parent = known ?? this.grow(name, prefix, parent, -1);
        if (known === undefined) groups.set(prefix, parent);
      }
      this.node_of_part[part] = this.grow(names.at(-1) ?? "", path, parent, part);
    }
  }

  node(index: number): PartNode {
    const node = this.nodes[index];
    if (!node) throw new RangeError(`the tree has no node ${index}`);
    return node;
  }

  /** The node of a part; -1 if there is none. */
  nodeOf(part: number): number {
    return this.node_of_part[part] ?? -1;
  }

  /** The ids of all parts at and below a node. */
  partsUnder(index: number): number[] {
    const parts: number[] = [];
    const waiting = [index];
    for (let next = waiting.pop(); next !== undefined; next = waiting.pop()) {
      const node = this.node(next);
      if (node.part >= 0) parts.push(node.part);
      for (let k = node.children.length - 1; k >= 0; k--) waiting.push(node.children[k] ?? 0);
    }
    return parts;
  }

  /** The groups above a node, the nearest first. */
  above(index: number): number[] {
    const found: number[] = [];
    for (let up = this.node(index).parent; up >= 0; up = this.node(up).parent) found.push(up);
    return found;
  }

  /** The group whose parts these are, all of them and no other; null: there is none. */
  groupOf(parts: ReadonlySet<number>): PartNode | null {
    const [first] = parts;
    if (first === undefined || parts.size < 2 || this.nodeOf(first) < 0) return null;
    for (const index of this.above(this.nodeOf(first))) {
      const under = this.partsUnder(index);
      if (under.length < parts.size) continue;
      return under.length === parts.size && under.every((part) => parts.has(part)) ? this.node(index) : null;
    }
    return null;
  }

  /** The ids of the parts whose path has every word of `query`; or those of `found`, where the server searched. */
  matching(query: string, found: ReadonlySet<number> | null = null): number[] {
    const isMatch = this.test(query, found);
    return this.nodes.filter((node, k) => node.part >= 0 && isMatch(node, k)).map((node) => node.part);
  }

  /**
   * The lines to show, from the top down.
   *
   * Without a query: the parts in open groups. With one: the parts that match and the groups above them, all open but those in
   * `shut`.
   */
  rows(
    open: ReadonlySet<number>,
    query = "",
    shut: ReadonlySet<number> = new Set(),
    found: ReadonlySet<number> | null = null,
  ): TreeRow[] {
    const isShown = query.trim() !== "" ? this.shownBy(this.test(query, found)) : null;
    const rows: TreeRow[] = [];
    const walk = (level: readonly number[]): void => {
      const shown = isShown ? level.filter((index) => isShown[index] === 1) : level;
      for (const [k, index] of shown.entries()) {
        const node = this.node(index);
        const isGroup = node.children.length > 0;
        const isOpen = isGroup && (isShown ? !shut.has(index) : open.has(index));
        rows.push({ node: index, depth: node.depth, isGroup, isOpen, place: k + 1, siblings: shown.length });
        if (isOpen) walk(node.children);
      }
    };
    walk(this.roots);
    return rows;
  }

  private test(query: string, found: ReadonlySet<number> | null): (node: PartNode, index: number) => boolean {
    if (found) return (node) => found.has(node.part);
    const words = wordsOf(query);
    return (_, index) => words.every((word) => this.searched[index]?.includes(word));
  }

  private shownBy(isMatch: (node: PartNode, index: number) => boolean): Uint8Array {
    const isShown = new Uint8Array(this.nodes.length);
    // Children stand behind their parents, so that one pass from the end carries matches up.
    for (let k = this.nodes.length - 1; k >= 0; k--) {
      if (isShown[k] === 0 && isMatch(this.node(k), k)) isShown[k] = 1;
      const parent = this.nodes[k]?.parent ?? -1;
      if (isShown[k] === 1 && parent >= 0) isShown[parent] = 1;
    }
    return isShown;
  }

  private grow(name: string, path: string, parent: number, part: number): number {
    const index = this.nodes.length;
    const depth = parent < 0 ? 0 : this.node(parent).depth + 1;
    this.nodes.push({ name, path, parent, depth, part, children: [] });
    this.searched.push(path.toLowerCase());
    (parent < 0 ? this.roots : this.node(parent).children).push(index);
    return index;
  }
}

/** Whether a search has a word of the form `name:value`, as `asks_for_attributes` of the server decides it. */
export function asksForAttributes(query: string): boolean {
  const words = query.match(/(?:"[^"]*(?:"|$)|[^\s"])+/g) ?? [];
  return words.some((word) => word.replaceAll('"', "").indexOf(":") > 0);
}

const wordsOf = (query: string): string[] =>
  query
    .toLowerCase()
    .split(/\s+/)
    .filter((word) => word !== "");
