// How well two colours are told apart.

/** The contrast of two colours by WCAG. */
export function contrast(one: number, other: number): number {
  const light = (colour: number): number =>
    [16, 8, 0]
      .map((shift) => ((colour >> shift) & 255) / 255)
      .map((c) => (c <= 0.03928 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4))
      .reduce((sum, c, k) => sum + c * ([0.2126, 0.7152, 0.0722][k] ?? 0), 0);
  const [a, b] = [light(one), light(other)].sort((x, y) => y - x) as [number, number];
  return (a + 0.05) / (b + 0.05);
}
