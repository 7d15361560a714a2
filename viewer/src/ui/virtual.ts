// The visible rows of a long list: all rows have one height, so they follow by arithmetic.

export interface Window {
  readonly first: number;
  /** One past the last. */
  readonly end: number;
}

const SPARE = 8;
/** There are never more, however tall the window; one more is left for the row that has the focus. */
export const MOST_ROWS = 79;

/** The rows of `count` that a viewport shows, with some to spare on both sides. Pixels. */
export function visibleRows(scroll_top: number, height: number, row_height: number, count: number): Window {
  const shown = Math.min(Math.ceil(height / row_height) + 1, MOST_ROWS);
  const spare = Math.min(SPARE, Math.floor((MOST_ROWS - shown) / 2));
  const top = Math.min(Math.max(0, Math.floor(scroll_top / row_height)), Math.max(0, count - shown));
  return { first: Math.max(0, top - spare), end: Math.min(count, top + shown + spare) };
}

/** The scroll position that makes `row` visible: `scroll_top` itself if it already is. */
export function scrollTo(row: number, scroll_top: number, height: number, row_height: number): number {
  const top = row * row_height;
  if (top < scroll_top) return top;
  return top + row_height > scroll_top + height ? top + row_height - height : scroll_top;
}
